//! Filling of pixels without samples. In go channels, out come the same with values from neighbours, ring by
//! ring from the rim of each hole inwards. Invariant: pixels with samples do not change, and the order of
//! threads has no effect.

use super::{Channel, Window};

/// Fills every pixel that is not `known`. In the first `mean_channels` channels it gets the mean of its known
/// neighbours. In the others it gets the first known one's value in reading order, as ids and depths do not
/// mix.
///
/// A window without known pixels stays as it is.
pub(super) fn fill(window: Window, mut known: Vec<bool>, channels: &mut [Channel], mean_channels: usize) {
    let mut holes: Vec<usize> = (0..known.len()).filter(|&pixel| !known[pixel]).collect();
    while !holes.is_empty() {
        let mut filled = Vec::new();
        for &hole in &holes {
            let neighbours: Vec<usize> = neighbours(window, hole).filter(|&pixel| known[pixel]).collect();
            let Some(&first) = neighbours.first() else { continue };
            filled.push(hole);
            for (number, channel) in channels.iter_mut().enumerate() {
                channel.pixels[hole] = if number < mean_channels {
                    let sum: f32 = neighbours.iter().map(|&pixel| channel.pixels[pixel]).sum();
                    sum / neighbours.len() as f32
                } else {
                    channel.pixels[first]
                };
            }
        }
        if filled.is_empty() {
            return;
        }
        // After the ring, so that its pixels do not fill each other.
        for &pixel in &filled {
            known[pixel] = true;
        }
        holes.retain(|&pixel| !known[pixel]);
    }
}

/// The up to eight pixels around `index`, in reading order.
fn neighbours(window: Window, index: usize) -> impl Iterator<Item = usize> {
    let (column, row) = (index % window.width, index / window.width);
    let rows = row.saturating_sub(1)..(row + 2).min(window.height);
    let columns = column.saturating_sub(1)..(column + 2).min(window.width);
    rows.flat_map(move |row| columns.clone().map(move |column| row * window.width + column))
        .filter(move |&neighbour| neighbour != index)
}

#[cfg(test)]
mod tests {
    use super::super::Precision;
    use super::*;

    const ROW: Window = Window { x: 0, y: 0, width: 5, height: 1 };

    fn filled(values: [f32; 5], known: [bool; 5], mean_channels: usize) -> Vec<f32> {
        let mut channels = [Channel::new("R", Precision::Float, values.to_vec())];
        fill(ROW, known.to_vec(), &mut channels, mean_channels);
        channels[0].pixels.clone()
    }

    #[test]
    fn a_hole_takes_the_mean_of_its_neighbours() {
        assert_eq!(
            filled([1.0, 0.0, 3.0, 5.0, 5.0], [true, false, true, true, true], 1),
            [1.0, 2.0, 3.0, 5.0, 5.0]
        );
    }

    #[test]
    fn an_id_is_taken_over_and_never_mixed() {
        assert_eq!(
            filled([1.0, 0.0, 3.0, 5.0, 5.0], [true, false, true, true, true], 0),
            [1.0, 1.0, 3.0, 5.0, 5.0]
        );
    }

    #[test]
    fn wide_holes_fill_from_the_rim_inwards() {
        assert_eq!(
            filled([2.0, 0.0, 0.0, 0.0, 4.0], [true, false, false, false, true], 1),
            [2.0, 2.0, 3.0, 4.0, 4.0]
        );
    }

    #[test]
    fn nothing_known_is_left_alone() {
        assert_eq!(filled([0.0; 5], [false; 5], 1), [0.0; 5]);
    }
}
