//! Reader of a file's bytes. In goes a file, out come values in order. Invariant: every read lies inside the
//! file, so no allocation exceeds the file's size.

use half::f16;

/// Fault of a file: its place, and the reason why a grid cannot be read.
#[derive(Debug)]
pub(super) struct Fault {
    /// Offset from the file's start in bytes.
    pub(super) at: usize,
    pub(super) what: String,
    /// Remedy, if writing the file again does not help.
    pub(super) remedy: Option<&'static str>,
}

/// Encoding of a number in a file.
#[derive(Clone, Copy)]
pub(super) enum Number {
    Half,
    Float,
    Double,
    Int32,
    Int64,
}

impl Number {
    pub(super) fn size(self) -> usize {
        match self {
            Self::Half => 2,
            Self::Float | Self::Int32 => 4,
            Self::Double | Self::Int64 => 8,
        }
    }

    /// The float nearest to a number of so many bytes.
    pub(super) fn of(self, bytes: &[u8]) -> f32 {
        match self {
            Self::Half => f16::from_le_bytes(array(bytes)).to_f32(),
            Self::Float => f32::from_le_bytes(array(bytes)),
            Self::Double => f64::from_le_bytes(array(bytes)) as f32,
            Self::Int32 => i32::from_le_bytes(array(bytes)) as f32,
            Self::Int64 => i64::from_le_bytes(array(bytes)) as f32,
        }
    }
}

fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|at| bytes[at])
}

/// Numbers of a value at most.
const MOST_NUMBERS: usize = 3;

/// Value of a voxel.
pub trait Value: Copy {
    /// Number of its components.
    const NUMBERS: usize;
    /// Value from its components.
    fn of(numbers: &[f32]) -> Self;
    /// Negated value.
    fn negated(self) -> Self;
    /// Whether every number is finite.
    fn is_finite(self) -> bool;
}

impl Value for f32 {
    const NUMBERS: usize = 1;

    fn of(numbers: &[f32]) -> Self {
        numbers[0]
    }

    fn negated(self) -> Self {
        -self
    }

    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }
}

impl Value for [f32; 3] {
    const NUMBERS: usize = 3;

    fn of(numbers: &[f32]) -> Self {
        [numbers[0], numbers[1], numbers[2]]
    }

    fn negated(self) -> Self {
        self.map(|number| -number)
    }

    fn is_finite(self) -> bool {
        self.iter().all(|number| number.is_finite())
    }
}

pub(super) type Read<T> = Result<T, Fault>;

/// Position of the next read.
#[derive(Clone)]
pub(super) struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    /// Reader of the same bytes from an offset; an offset beyond the end fails at the next read.
    pub(super) fn from(&self, at: i64) -> Read<Self> {
        let at = usize::try_from(at).map_err(|_| self.fault("a place before the file's start is named"))?;
        Ok(Self { all: self.all, at })
    }

    /// Offset from the file's start in bytes.
    pub(super) fn place(&self) -> i64 {
        self.at as i64
    }

    pub(super) fn fault(&self, what: impl Into<String>) -> Fault {
        Fault { at: self.at, what: what.into(), remedy: None }
    }

    pub(super) fn take(&mut self, count: usize) -> Read<&'a [u8]> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.all.len());
        let end = end.ok_or_else(|| self.fault(format!("the file ends before {count} bytes more")))?;
        let taken = &self.all[self.at..end];
        self.at = end;
        Ok(taken)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Read<[u8; N]> {
        self.take(N).map(array)
    }

    pub(super) fn u8(&mut self) -> Read<u8> {
        Ok(self.array::<1>()?[0])
    }

    pub(super) fn u32(&mut self) -> Read<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn i64(&mut self) -> Read<i64> {
        self.array().map(i64::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Read<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// A number or vector.
    pub(super) fn value<V: Value>(&mut self, written: Number) -> Read<V> {
        let mut numbers = [0.0; MOST_NUMBERS];
        for number in &mut numbers[..V::NUMBERS] {
            *number = written.of(self.take(written.size())?);
        }
        Ok(V::of(&numbers))
    }

    /// Reads integer coordinates of a voxel.
    pub(super) fn voxel(&mut self) -> Read<[i32; 3]> {
        Ok([self.u32()? as i32, self.u32()? as i32, self.u32()? as i32])
    }

    /// Reads a text after its length.
    pub(super) fn text(&mut self) -> Read<String> {
        let length = self.u32()? as usize;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    /// Reads the bit mask of a node, lowest bit first.
    pub(super) fn mask(&mut self, count: usize) -> Read<Mask<'a>> {
        self.take(count / 8).map(Mask)
    }
}

/// Bit mask of a node's places.
#[derive(Clone, Copy)]
pub(super) struct Mask<'a>(&'a [u8]);

impl Mask<'_> {
    pub(super) fn is_on(self, place: usize) -> bool {
        self.0[place / 8] >> (place % 8) & 1 == 1
    }

    pub(super) fn count(self) -> usize {
        self.0.iter().map(|byte| byte.count_ones() as usize).sum()
    }

    /// Places whose bits are set, in order.
    pub(super) fn places(self) -> impl Iterator<Item = usize> {
        (0..8 * self.0.len()).filter(move |&place| self.is_on(place))
    }
}
