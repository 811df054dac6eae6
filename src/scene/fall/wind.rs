//! Velocity of the air. In go a place and a time, out comes a velocity. Invariant: eddies are free of
//! divergence, so they neither gather nor scatter leaves, and every machine computes the same bits.

use crate::math::Chance;
use crate::scene::Track;
use crate::scene::drift::Drift;
use glam::DVec3;
use std::f64::consts::TAU;

/// Number of waves in the eddies.
const WAVES: u32 = 10;
/// Longest and shortest wavelength, relative to the eddies' size.
const LENGTHS: (f64, f64) = (1.6, 0.3);
/// Energy over wave number falls as in turbulence, so velocity goes as the cube root of length
/// (Kolmogorov 1941).
const VELOCITY_EXPONENT: f64 = 1.0 / 3.0;

/// Mean wind, gusts and eddies.
#[derive(Clone, Debug)]
pub(crate) struct Wind {
    mean: Drift,
    /// Velocity that carries gusts, and its squared length.
    carrier: (DVec3, f64),
    gust: Track<DVec3>,
    gust_s: f64,
    seed: u32,
    /// Waves of the eddies at their greatest strength.
    waves: Vec<Wave>,
    /// Strength of the eddies relative to that.
    eddy: Track<f64>,
}

/// Transverse wave of the air.
#[derive(Clone, Copy, Debug)]
struct Wave {
    /// Phase per metre, and per second in the frame of the mean wind.
    per_m: DVec3,
    per_s: f64,
    phase: f64,
    /// Velocity, perpendicular to `per_m` and so without divergence.
    velocity: DVec3,
}

/// Gusts on top of the mean wind: the strongest one's velocity, and the mean interval, seconds.
pub(crate) struct Gusts<T> {
    pub(crate) speed_m_per_s: T,
    pub(crate) every_s: f64,
}

/// Eddies: the root mean square of their velocity, and their size.
pub(crate) struct Eddies<T> {
    pub(crate) speed_m_per_s: T,
    pub(crate) size_m: f64,
}

impl Wind {
    /// Gusts travel with the mean wind at its strongest; a changing speed would move all of them at once.
    pub(crate) fn new(
        mean: impl Into<Track<DVec3>>,
        Gusts { speed_m_per_s: gust, every_s: gust_s }: Gusts<impl Into<Track<DVec3>>>,
        Eddies { speed_m_per_s: eddy, size_m: eddy_m }: Eddies<impl Into<Track<f64>>>,
        seed: u32,
    ) -> Self {
        let (mean, eddy) = (mean.into(), eddy.into());
        let eddy_m_per_s = eddy.hull().into_iter().fold(0.0, f64::max);
        let strongest = |a: DVec3, b: DVec3| if b.length_squared() > a.length_squared() { b } else { a };
        let carrier = mean.hull().into_iter().fold(DVec3::ZERO, strongest);
        let mut waves = Vec::new();
        if eddy_m_per_s > 0.0 {
            waves.extend(
                (0..WAVES).map(|number| wave(Chance::of(seed, number), number, eddy_m_per_s, eddy_m)),
            );
            let energy: f64 = waves.iter().map(|wave: &Wave| 0.5 * wave.velocity.length_squared()).sum();
            waves.iter_mut().for_each(|wave| wave.velocity *= eddy_m_per_s / energy.sqrt());
        }
        let eddy = eddy.map_linear(|speed| if eddy_m_per_s > 0.0 { speed / eddy_m_per_s } else { 0.0 });
        let (mean, carrier) = (Drift::new(mean), (carrier, carrier.length_squared()));
        Self { mean, carrier, gust: gust.into(), gust_s, seed, waves, eddy }
    }

    /// Velocity of the air, m/s.
    pub(crate) fn at(&self, place: DVec3, time_s: f64) -> DVec3 {
        let mut velocity = self.mean.velocity(time_s);
        let gust = self.gust.at(time_s);
        if gust != DVec3::ZERO {
            // Gusts travel with the mean wind (Taylor's frozen turbulence).
            let (carrier, speed_squared) = self.carrier;
            let late_s = if speed_squared > 0.0 { place.dot(carrier) / speed_squared } else { 0.0 };
            velocity += gust * self.gustiness(time_s - late_s);
        }
        if self.waves.is_empty() {
            return velocity;
        }
        let (carried, strength) = (place - self.mean.way(time_s), self.eddy.at(time_s));
        for wave in &self.waves {
            let phase = wave.per_m.dot(carried) + wave.per_s * time_s + wave.phase;
            velocity += wave.velocity * (strength * libm::cos(phase));
        }
        velocity
    }

    /// Strength of gusts, from 0 between them to at most 1, with a continuous derivative.
    fn gustiness(&self, time_s: f64) -> f64 {
        let number = (time_s / self.gust_s).floor();
        let within = time_s / self.gust_s - number;
        let strength = Chance::of(self.seed, number as i64 as u32).at(u64::from(WAVES) * 8);
        let bell = within * (1.0 - within);
        16.0 * strength * bell * bell
    }
}

fn wave(chance: Chance, number: u32, eddy_m_per_s: f64, eddy_m: f64) -> Wave {
    let fraction = f64::from(number) / f64::from(WAVES - 1);
    let length = LENGTHS.0 * libm::pow(LENGTHS.1 / LENGTHS.0, fraction);
    let per_m = direction(chance, 0) * (TAU / (length * eddy_m));
    // Any direction other than the wave's own has a transverse component.
    let across = per_m.cross(direction(chance, 2)).normalize_or(per_m.any_orthonormal_vector());
    let velocity = across * libm::pow(length, VELOCITY_EXPONENT);
    // An eddy turns over in the time that its air takes to cross it.
    let per_s = (2.0 * chance.at(4) - 1.0) * TAU * eddy_m_per_s / (length * eddy_m);
    Wave { per_m, per_s, phase: TAU * chance.at(5), velocity }
}

/// Uniform unit vector, from two draws.
fn direction(chance: Chance, draw: u64) -> DVec3 {
    let y = 1.0 - 2.0 * chance.at(draw);
    let (sin, cos) = libm::sincos(TAU * chance.at(draw + 1));
    let radius = (1.0 - y * y).max(0.0).sqrt();
    DVec3::new(radius * cos, y, radius * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn storm() -> Wind {
        Wind::new(
            DVec3::new(3.0, 0.0, 1.0),
            Gusts { speed_m_per_s: DVec3::new(4.0, 0.0, 0.0), every_s: 3.0 },
            Eddies { speed_m_per_s: 1.5, size_m: 2.0 },
            7,
        )
    }

    fn places() -> impl Iterator<Item = (DVec3, f64)> {
        (0..4000).map(|item| {
            let chance = Chance::of(1, item);
            let place = DVec3::new(chance.at(0), chance.at(1), chance.at(2)) * 100.0;
            (place, 50.0 * chance.at(3))
        })
    }

    #[test]
    fn calm_air_does_not_move() {
        let calm = Wind::new(
            DVec3::ZERO,
            Gusts { speed_m_per_s: DVec3::ZERO, every_s: 1.0 },
            Eddies { speed_m_per_s: 0.0, size_m: 1.0 },
            3,
        );
        assert!(places().all(|(place, time_s)| calm.at(place, time_s) == DVec3::ZERO));
    }

    #[test]
    fn eddies_have_no_divergence_and_the_speed_asked_for() {
        let eddies = Wind::new(
            DVec3::X,
            Gusts { speed_m_per_s: DVec3::ZERO, every_s: 1.0 },
            Eddies { speed_m_per_s: 1.5, size_m: 2.0 },
            7,
        );
        let (step, mut square, mut count) = (1e-4, 0.0, 0.0);
        for (place, time_s) in places() {
            let difference = |axis: DVec3| {
                (eddies.at(place + axis * step, time_s) - eddies.at(place - axis * step, time_s))
                    / (2.0 * step)
            };
            let divergence = difference(DVec3::X).x + difference(DVec3::Y).y + difference(DVec3::Z).z;
            assert!(divergence.abs() < 1e-6, "{divergence}");
            square += (eddies.at(place, time_s) - DVec3::X).length_squared();
            count += 1.0;
        }
        let rms = f64::sqrt(square / count);
        assert!((rms - 1.5).abs() < 0.1, "{rms}");
    }

    #[test]
    fn gusts_add_at_most_what_they_may_and_come_with_the_wind() {
        let gusts = Wind::new(
            DVec3::X * 2.0,
            Gusts { speed_m_per_s: DVec3::X * 4.0, every_s: 3.0 },
            Eddies { speed_m_per_s: 0.0, size_m: 1.0 },
            7,
        );
        let speeds: Vec<f64> =
            (0..3000).map(|step| gusts.at(DVec3::ZERO, 0.01 * f64::from(step)).x).collect();
        let (low, high) = speeds.iter().fold((9.0_f64, 0.0_f64), |(low, high), &x| (low.min(x), high.max(x)));
        assert!((2.0..2.1).contains(&low) && (4.0..=6.0).contains(&high), "{low} {high}");
        // A place further down the wind has it later.
        assert_eq!(gusts.at(DVec3::X * 6.0, 5.0), gusts.at(DVec3::ZERO, 2.0));
    }

    #[test]
    fn wind_changes_smoothly() {
        let wind = storm();
        for (place, time_s) in places() {
            let change = wind.at(place, time_s + 1e-4) - wind.at(place, time_s);
            assert!(change.length() < 50.0 * 1e-4, "{change}");
        }
    }
}
