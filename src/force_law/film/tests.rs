//! Tests of the lubricant film: integral of the pressure, dissipation, slopes against differences.

use pulp::{Simd, WithSimd};

use super::*;
use crate::math::simd::{InstructionSet, Lanes};

const LUBRICANT: Film = Film {
    viscosity: 0.1,
    length: None,
    handover: 0.9,
    tension: 0.0,
};

/// The hinge of the published drive.
fn hinge() -> HingeFilm {
    LUBRICANT.between(2.22e-3, 25e-6, 0.011)
}

/// The same hinge with films that sustain tension; the states have velocities at, above and below g₀.
fn hinges() -> [HingeFilm; 4] {
    [0.0, 3e2, 1e4, 3e6].map(|tension| {
        Film {
            tension,
            ..LUBRICANT
        }
        .between(2.22e-3, 25e-6, 0.011)
    })
}

/// Ratios of eccentricity to clearance, and velocities \[m/s\].
fn states() -> Vec<(f64, [f64; 2])> {
    let ratios = [1e-9, 1e-3, 0.05, 0.3, 0.6, 0.85, 0.93, 0.97, 0.999];
    let angles = (0..16).map(|i| f64::from(i) * PI / 8.0 + 0.01);
    ratios
        .into_iter()
        .flat_map(|ratio| angles.clone().map(move |angle| (ratio, angle)))
        .map(|(ratio, angle)| (ratio, [2e-3 * angle.cos(), 2e-3 * angle.sin()]))
        .collect()
}

#[test]
fn forces_are_the_integral_of_the_pressure_that_is_positive() {
    let film = hinge();
    for (ratio, [along, across]) in states() {
        if ratio > 0.9 {
            continue;
        }
        let g = [along, 2.0 * across / (2.0 + ratio * ratio)];
        // Simpson's rule between the two zeros of the pressure.
        let (parts, middle) = (20_000, g[1].atan2(g[0]));
        let mut sum = [0.0; 2];
        for i in 0..=parts {
            let angle = middle + PI * (f64::from(i) / f64::from(parts) - 0.5);
            let (sin, cos) = angle.sin_cos();
            let thin = 1.0 - ratio * cos;
            let pressure = (2.0 - ratio * cos) / (thin * thin) * (g[0] * cos + g[1] * sin);
            let weight = match i {
                0 => 1.0,
                i if i == parts => 1.0,
                i => f64::from(2 + 2 * (i % 2)),
            };
            sum[0] += weight * pressure * cos;
            sum[1] += weight * pressure * sin;
        }
        let most = -film.pressure * PI / (3.0 * f64::from(parts));
        let found = film.at(ratio * film.clearance, [along, across]).force;
        for (found, sum) in found.iter().zip(sum) {
            let size = film.pressure * 2e-3;
            assert!((found - most * sum).abs() < 1e-9 * size, "{ratio} {along}");
        }
    }
}

#[test]
fn nothing_is_ever_gained_from_a_film() {
    for film in hinges() {
        for (ratio, velocity) in states() {
            let found = film.at(ratio * film.clearance, velocity);
            let [along, across] = found.force;
            assert!(along * velocity[0] + across * velocity[1] < 0.0, "{ratio}");
            assert!(found.shear > 0.0);
        }
    }
}

#[test]
fn small_pressures_have_the_full_film() {
    let [.., film] = hinges();
    for ratio in [0.05f64, 0.4, 0.8] {
        let rest = 1.0 - ratio * ratio;
        let full = 2.0 * PI * film.pressure;
        let found = film.at(ratio * film.clearance, [-1e-8, 1e-8]).force;
        let expected = [
            full * 1e-8 / rest.powf(1.5),
            -full * 2e-8 / ((2.0 + ratio * ratio) * rest.sqrt()),
        ];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-5 * expected.abs(), "{ratio}");
        }
    }
}

#[test]
fn any_velocity_changes_the_slopes_of_a_half_film_at_rest() {
    let film = HingeFilm {
        speed: 0.0,
        ..hinge()
    };
    // The second g has a square below the least positive number.
    for velocity in [[0.0, 0.0], [1e-200, 0.0]] {
        for set in InstructionSet::available() {
            let mut found = Vec::new();
            set.run(Fill {
                film,
                states: &[(0.5, velocity)],
                found: &mut found,
            });
            let inverse = found[0][9];
            assert!(inverse > 1e50 && (inverse * inverse).is_finite());
        }
    }
}

#[test]
fn the_hand_over_is_smooth_and_complete() {
    let film = hinge();
    let at = |ratio: f64| film.at(ratio * film.clearance, [1e-3, 1e-3]).force[0];
    for edge in [0.9, 1.0] {
        let step = 1e-6;
        let jump = at(edge + step) - at(edge - step);
        assert!(jump.abs() < 1e-3 * at(0.9).abs(), "{edge}: {jump}");
    }
    assert_eq!(at(1.0), 0.0);
    assert_eq!(at(1.2), 0.0);
}

struct Fill<'a> {
    film: HingeFilm,
    states: &'a [(f64, [f64; 2])],
    found: &'a mut Vec<[f64; 10]>,
}

impl WithSimd for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let film = FilmLaw::new(simd, &self.film);
        for &(ratio, [along, across]) in self.states {
            let splat = |value| Lanes::splat(simd, value);
            let length = splat(ratio * self.film.clearance);
            let filled = film.at(length, [splat(along), splat(across)], splat(1.0));
            let slopes = film.slopes(&filled);
            let [dxx, dyy, dxy] = slopes.damping;
            let [kxx, kyy, kxy] = slopes.stiffness;
            let FilmForce {
                force: [push, drag],
                shear,
            } = filled.film;
            let speed = slopes.inverse_speed;
            let all = [push, drag, shear, dxx, dyy, dxy, kxx, kyy, kxy, speed];
            self.found.push(all.map(Lanes::greatest));
        }
    }
}

#[test]
fn vectors_give_what_single_films_give_and_slopes_those_of_differences() {
    let films = hinges();
    let c = films[0].clearance;
    let states = states();
    let sets = InstructionSet::available().into_iter();
    for (set, film) in sets.flat_map(|set| films.map(|film| (set, film))) {
        let mut found = Vec::new();
        set.run(Fill {
            film,
            states: &states,
            found: &mut found,
        });
        for (&(ratio, velocity), found) in states.iter().zip(&found) {
            let scalar = film.at(ratio * c, velocity);
            let size = scalar.force[0].hypot(scalar.force[1]);
            for (found, scalar) in found.iter().zip(scalar.force) {
                // The two terms of the tensile force of a thin film nearly cancel.
                assert!((found - scalar).abs() < 1e-12 * size / (1.0 - ratio));
            }
            assert!((found[2] - scalar.shear).abs() < 1e-12 * scalar.shear);
            // One over √(g² + g₀²), g = (u_r, 2 u_t/(2 + ε²)).
            let g = velocity[0].hypot(2.0 * velocity[1] / (2.0 + ratio * ratio));
            assert!((found[9] * g.hypot(film.speed) - 1.0).abs() < 1e-12);
            if ratio < 0.05 {
                continue;
            }
            // Positions and velocities in a plane that does not rotate.
            let force = |dx: f64, dy: f64, du: f64, dv: f64| {
                let (x, y) = (ratio * c + dx, dy);
                let length = x.hypot(y);
                let (cos, sin) = (x / length, y / length);
                let (u, v) = (velocity[0] + du, velocity[1] + dv);
                let [push, drag] = film
                    .at(length, [u * cos + v * sin, v * cos - u * sin])
                    .force;
                [push * cos - drag * sin, push * sin + drag * cos]
            };
            let slope = |axis: usize, step: f64| {
                let mut way = [0.0; 4];
                way[axis] = step;
                let [a, b, e, f] = way;
                let (up, down) = (force(a, b, e, f), force(-a, -b, -e, -f));
                [0, 1].map(|i| -(up[i] - down[i]) / (2.0 * step))
            };
            let [kx, ky] = [slope(0, 1e-6 * c), slope(1, 1e-6 * c)];
            let [dx, dy] = [slope(2, 1e-9), slope(3, 1e-9)];
            let expected = [
                dx[0],
                dy[1],
                0.5 * (dx[1] + dy[0]),
                kx[0],
                ky[1],
                0.5 * (kx[1] + ky[0]),
            ];
            for (i, (found, expected)) in found[3..9].iter().zip(expected).enumerate() {
                let size = if i < 3 {
                    size / 2e-3
                } else {
                    size / c / (1.0 - ratio)
                };
                assert!(
                    (found - expected).abs() < 1e-4 * size,
                    "{ratio} {velocity:?}, slope {i}: {found} for {expected}"
                );
            }
        }
    }
}

#[test]
fn films_that_mean_nothing_are_refused() {
    let bad = |change: fn(&mut Film)| {
        let mut film = LUBRICANT;
        change(&mut film);
        film.check("Film").unwrap_err().to_string()
    };
    assert!(bad(|film| film.viscosity = 0.0).contains("leave the film out"));
    assert!(bad(|film| film.viscosity = f64::NAN).contains("Film.viscosity"));
    assert!(bad(|film| film.length = Some(-1.0)).contains("Film.length"));
    assert!(bad(|film| film.handover = 1.0).contains("Film.handover"));
    assert!(bad(|film| film.tension = -1.0).contains("Film.tension"));
}

#[test]
fn constants_of_a_hinge_are_those_of_the_printed_formulas() {
    let film = Film {
        tension: 3e4,
        ..LUBRICANT
    }
    .between(2e-3, 5e-5, 0.01);
    // μ L R³ = 0.1 Pa s · 0.01 m · 8e-9 m³ = 8e-12 Pa s m⁴
    assert!((film.pressure / (6.0 * 8e-12 / 1.25e-13) - 1.0).abs() < 1e-14);
    assert!((film.shear / (2.0 * PI * 8e-12 / 5e-5) - 1.0).abs() < 1e-14);
    // g₀ = p c³/(6 μ R²)
    assert!((film.speed / (3e4 * 1.25e-13 / (0.6 * 4e-6)) - 1.0).abs() < 1e-14);
    let own_length = Film {
        length: Some(0.02),
        ..LUBRICANT
    };
    let long = own_length.between(2e-3, 5e-5, 0.01);
    assert!((long.pressure / film.pressure - 2.0).abs() < 1e-14);
    // Petroff's torque over sqrt(1 - ε²); in the middle of the transition half of it.
    let shear = |ratio: f64| film.at(ratio * film.clearance, [1e-3, 2e-3]).shear / film.shear;
    assert!((shear(0.6) - 1.25).abs() < 1e-12);
    assert!((shear(0.95) - 0.5 / (1.0 - 0.95f64.powi(2)).sqrt()).abs() < 1e-9);
}

#[test]
fn derivatives_of_a_single_film_are_those_of_differences() {
    for film in hinges() {
        let c = film.clearance;
        for (ratio, [along, across]) in states() {
            let (found, gradient) = film.slopes(ratio * c, [along, across]);
            assert_eq!(found, film.at(ratio * c, [along, across]));
            if ratio < 0.05 {
                continue;
            }
            let size = found.force[0].hypot(found.force[1]);
            let (by_length, by_speed) = (size / c / (1.0 - ratio), size / 2e-3);
            let steps = [1e-6 * c * (1.0 - ratio), 1e-9, 1e-9];
            for (k, step) in steps.into_iter().enumerate() {
                let moved = |sign: f64| {
                    let mut at = [ratio * c, along, across];
                    at[k] += sign * step;
                    film.at(at[0], [at[1], at[2]])
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                let scale = if k == 0 { by_length } else { by_speed };
                for i in 0..2 {
                    let slope = (up.force[i] - down.force[i]) / (2.0 * step);
                    let error = gradient.force[i][k] - slope;
                    assert!(
                        error.abs() < 1e-4 * scale,
                        "{ratio} {along} {i} {k}: {error}"
                    );
                }
                if k == 0 {
                    let slope = (up.shear - down.shear) / (2.0 * step);
                    let scale = found.shear / c / (1.0 - ratio);
                    assert!((gradient.shear - slope).abs() < 1e-4 * scale, "{ratio}");
                }
            }
        }
        let (dry, gradient) = film.slopes(c, [1e-3, 1e-3]);
        assert_eq!(dry.force, [0.0; 2]);
        assert_eq!((gradient.force, gradient.shear), ([[0.0; 3]; 2], 0.0));
    }
}

#[test]
fn a_film_at_rest_has_finite_derivatives() {
    for film in hinges() {
        for ratio in [0.0, 0.3, 0.95] {
            let (found, gradient) = film.slopes(ratio * film.clearance, [0.0, 0.0]);
            assert_eq!(found.force, [0.0, 0.0]);
            let slopes = gradient.force.iter().flatten();
            assert!(
                slopes
                    .chain([&gradient.shear])
                    .all(|slope| slope.is_finite()),
                "{ratio}"
            );
        }
    }
}
