//! Slopes of the force laws against complex steps: `Im f(δ + ih)/h` has no difference that cancels, and is right to rounding.
//!
//! The laws are written here anew, as they are printed, for complex numbers; of the enhanced one only its form, K δ^n.

use std::f64::consts::PI;

use num_complex::Complex64;
use rustchain::force_law::{Elastic, ElasticPair, SurfacePair};

const MODULUS: f64 = 2.07e11 / 1.82;

/// A pin in its bushing, a bushing on the working curve, on the topping curve.
fn surfaces() -> [SurfacePair; 3] {
    [
        SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, MODULUS),
        SurfacePair::internal(3.968_75e-3, 10.376_694e-3, 0.007, MODULUS),
        SurfacePair::external(3.968_75e-3, 6.582_621e-3, 0.007, MODULUS),
    ]
}

/// δ of the laws of line contact for a force, and dδ/df.
fn depth_of_line(law: Elastic, on: &SurfacePair, force: Complex64) -> [Complex64; 2] {
    let f = force / on.length;
    let (e, dr) = (on.contact_modulus, on.radius_difference);
    // δ = s f [ln(b/f) + c]: dδ/df = s [ln(b/f) + c - 1]
    let (s, b, c) = match law {
        Elastic::Johnson => (1.0 / (PI * e), 4.0 * PI * e * dr, -1.0),
        Elastic::HertzCylinder => (2.0 / (PI * e), PI * e * dr, -1.0),
        Elastic::Radzimovsky => (1.0 / (PI * e), 16.0 / 2.56 * e * dr, 2.0 / 3.0),
        Elastic::Esdu78035 => (1.0 / (PI * e), 4.0 * PI * e * dr, 1.0),
        other => panic!("{other:?} is no law of line contact"),
    };
    let bracket = (Complex64::from(b) / f).ln() + c;
    [s * f * bracket, s / on.length * (bracket - 1.0)]
}

/// Force at a complex depth; `near` is the real force at its real part.
fn force(law: Elastic, on: &SurfacePair, depth: Complex64, near: f64) -> Complex64 {
    let (e, dr, length) = (on.contact_modulus, on.radius_difference, on.length);
    match law {
        Elastic::Hertz => 4.0 / 3.0 * e * on.effective_radius.sqrt() * depth.powf(1.5),
        Elastic::LiuConformal => {
            PI / 2.0 * e * length * depth * (depth / (2.0 * (dr + depth))).sqrt()
        }
        Elastic::Linear(stiffness) => stiffness * depth,
        _ => {
            let mut force = Complex64::from(near);
            for _ in 0..40 {
                let [reached, slope] = depth_of_line(law, on, force);
                force -= (reached - depth) / slope;
            }
            force
        }
    }
}

#[test]
fn slopes_of_the_elastic_laws_are_those_of_complex_steps() {
    let laws = [
        Elastic::Hertz,
        Elastic::LiuConformal,
        Elastic::Linear(2e8),
        Elastic::Johnson,
        Elastic::HertzCylinder,
        Elastic::Radzimovsky,
        Elastic::Esdu78035,
    ];
    for law in laws {
        for on in surfaces() {
            let pair = ElasticPair::prepare(law, &on);
            for depth in [1e-9, 1e-7, 2.6e-6] {
                let near = pair.force(depth);
                let step = 1e-30;
                let at = force(law, &on, Complex64::new(depth, step), near);
                assert!(
                    (at.re / near - 1.0).abs() < 1e-12,
                    "{law:?} {depth} {at} {near}"
                );
                let (slope, exact) = (pair.stiffness(depth), at.im / step);
                assert!(
                    (slope / exact - 1.0).abs() < 1e-12,
                    "{law:?} {depth} {slope} {exact}"
                );
            }
        }
    }
}

/// The enhanced law is K δ^n: K and n are found from two forces, the slope from neither.
#[test]
fn slopes_of_the_enhanced_law_are_those_of_complex_steps() {
    for law in [Elastic::EnhancedCylinder, Elastic::EnhancedCylinder2015] {
        for on in surfaces() {
            let pair = ElasticPair::prepare(law, &on);
            let n = (pair.force(1e-4) / pair.force(1e-8)).ln() / 1e4f64.ln();
            let k = pair.force(1e-6) / 1e-6f64.powf(n);
            for depth in [1e-9, 1e-7, 2.6e-6] {
                let step = 1e-30;
                let exact = (k * Complex64::new(depth, step).powf(n)).im / step;
                let slope = pair.stiffness(depth);
                assert!(
                    (slope / exact - 1.0).abs() < 1e-12,
                    "{law:?} {depth} {slope} {exact}"
                );
            }
        }
    }
}
