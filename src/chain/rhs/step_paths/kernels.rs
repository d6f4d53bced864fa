//! Paths of all contacts of a drive: kernels in the order of their dependence, and the powers of the whole drive.

use std::marker::PhantomData;

use super::joints::{Bore, TraceHinges, TraceRollers};
use super::powers::{Constants, Found, PowersInside};
use super::teeth::TraceTeeth;
use super::{Inside, Path, PathTracer};
use crate::chain::contact::ImpactMemory;
use crate::chain::dynamics::Moves;
use crate::chain::dynamics::{Losses, Powers, SprocketLoad, outside_powers, sprocket_acceleration};
use crate::chain::model::{ContactLaw, Model, Rotation};
use crate::chain::motion::sprocket_motion;
use crate::chain::rhs::Kernels;
use crate::chain::rhs::chain::Point;
use crate::chain::rhs::gap::Form;
use crate::force_law::{ElasticLaw, Friction, with_law};
use crate::geometry::Vec2;

impl Kernels {
    /// Write the end of a step into `tracer`: all contacts at (`t`, `y`) with the `slope` of y. The last evaluation was there, or
    /// `nearby`, within the tolerance; candidates and their gaps are always those of the last evaluation.
    pub(crate) fn trace(
        &mut self,
        model: &Model,
        pawls: &[f64],
        (t, y, slope): (f64, &[f64], &[f64]),
        nearby: bool,
        tracer: &mut PathTracer,
    ) {
        tracer.follow(&self.candidates, model.links);
        if nearby {
            self.place_sprockets(model, t, y);
            self.instructions.run(Point {
                angle: columns(y, 0, model.links)[2],
                arrays: &mut self.chain,
            });
            self.turn_poses();
        }
        self.trace_joints(model, y, slope, tracer);
        let PathTracer {
            paths,
            law,
            bushings,
            rollers,
            ..
        } = tracer;
        let bodies = if model.rollers.is_some() {
            rollers
        } else {
            bushings
        };
        bodies.repeat(model.links, self.candidates.overhang);
        let friction_radius = model.teeth.friction.map(|_| model.teeth.contact_radius);
        for (s, sprocket) in model.sprockets.iter().enumerate() {
            let pose = &self.poses[s];
            let (acceleration, spin_rate) = sprocket_acceleration(
                sprocket,
                model.gravity,
                &pose.moves(),
                &self.loads[s],
                pawls[s],
                t,
            );
            macro_rules! trace {
                ($constants:expr) => {
                    self.instructions.run(TraceTeeth {
                        constants: $constants,
                        pose,
                        acceleration: acceleration.into(),
                        spin_rate,
                        bodies: &*bodies,
                        friction_radius,
                        candidates: &self.candidates.sprockets[s],
                        ends: &mut paths.teeth[s].end,
                        law: &mut law[s],
                    })
                };
            }
            match &self.teeth[self.kind[s]].form {
                Form::Ansi(gap) => trace!(gap),
                Form::Table(gap) => trace!(gap),
            }
        }
    }

    /// Write hinges and rollers at the end of a step, and the motion of bushings and rollers.
    fn trace_joints(&self, model: &Model, y: &[f64], slope: &[f64], tracer: &mut PathTracer) {
        let PathTracer {
            paths,
            bushings,
            rollers,
            ..
        } = tracer;
        let n = model.links;
        let (q, v) = y.split_at(model.coordinates);
        let a = &slope[model.coordinates..];
        let rubs = model.hinges.friction.is_some();
        self.instructions.run(TraceHinges {
            places: [&q[..n], &q[n..2 * n]],
            speeds: columns(v, 0, n),
            accelerations: columns(a, 0, n),
            bore: Bore {
                clearance: model.hinges.clearance,
                friction_radius: rubs.then_some(model.hinges.pin_radius),
            },
            constants: &self.links,
            direction: [&self.chain.cos, &self.chain.sin],
            ends: &mut paths.hinges.end,
            bushings,
        });
        if let (Some(of), Some(own)) = (&model.rollers, &self.rollers) {
            let [x, y, _] = columns(q, of.first, n);
            self.instructions.run(TraceRollers {
                places: [x, y],
                speeds: columns(v, of.first, n),
                accelerations: columns(a, of.first, n),
                bore: Bore {
                    clearance: of.clearance,
                    friction_radius: rubs.then_some(of.bushing_radius),
                },
                constants: &own.constants,
                ends: &mut paths.rollers.end,
                bushings,
                rollers,
            });
        }
    }

    /// Return the powers inside a step between both ends of `tracer`; `value` returns the value and rate of a coordinate there.
    pub(crate) fn powers_inside(
        &self,
        model: &Model,
        memory: &ImpactMemory,
        tracer: &PathTracer,
        inside: Inside,
        value: impl Fn(usize) -> (f64, f64),
    ) -> Powers {
        let paths = &tracer.paths;
        let joints = |path: &Path, law: &ContactLaw, inverse_onset: &[f64]| {
            let friction = model.hinges.friction.as_ref();
            if law.lambda == 0.0 && friction.is_none() {
                return Found::default();
            }
            with_law!(&law.pairs, Law, pairs => {
                let constants = Constants::Same(pairs[0]);
                self.inside::<Law>(model, path, inside, (law.lambda, friction), (constants, inverse_onset, model.links))
            })
        };
        let hinges = joints(&paths.hinges, &model.hinges.law, memory.hinge_inverse());
        let rollers = model.rollers.as_ref().map_or(Found::default(), |of| {
            joints(&paths.rollers, &of.law, memory.roller_inverse())
        });
        let mut losses = Losses {
            hinge_contact: hinges.dissipated,
            hinge_friction: hinges.rubbed,
            roller_contact: rollers.dissipated,
            roller_friction: rollers.rubbed,
            ..Losses::default()
        };
        let mut outside = Powers::default();
        for (s, sprocket) in model.sprockets.iter().enumerate() {
            let teeth = self.teeth_inside(model, s, tracer, inside);
            losses.tooth_contact += teeth.dissipated;
            losses.tooth_friction += teeth.rubbed;
            let ((center, velocity), (angle, spin)) = sprocket_motion(sprocket, inside.t, &value);
            let moves = Moves {
                center,
                velocity,
                angle,
                spin,
            };
            let load = SprocketLoad {
                force: Vec2::zeros(),
                moment: teeth.moment,
            };
            outside += outside_powers(sprocket, &moves, &load, inside.t);
        }
        Powers::of(losses) + outside
    }

    /// Return the powers of the candidates of sprocket `s`, and the moment on it.
    fn teeth_inside(&self, model: &Model, s: usize, tracer: &PathTracer, inside: Inside) -> Found {
        let (law, friction) = (&model.teeth.law, model.teeth.friction.as_ref());
        let turned = matches!(model.sprockets[s].rotation, Rotation::Prescribed(_));
        if law.lambda == 0.0 && friction.is_none() && !turned {
            return Found::default();
        }
        let candidates = &self.candidates.sprockets[s];
        let kept = (self.teeth[self.kind[s]].keeps_stiffness).then_some(&candidates.kept_constants);
        let constants = Constants::Slots(&tracer.law[s], kept);
        let slots = candidates.gap.len();
        with_law!(&law.pairs, Law, _pairs => {
            self.inside::<Law>(
                model,
                &tracer.paths.teeth[s],
                inside,
                (law.lambda, friction),
                (constants, &candidates.inverse_onset, slots),
            )
        })
    }

    /// Return the powers of one kind of contacts.
    fn inside<L: ElasticLaw>(
        &self,
        model: &Model,
        path: &Path,
        Inside { part, length, .. }: Inside,
        (lambda, friction): (f64, Option<&Friction>),
        (constants, inverse_onset, contacts): (Constants, &[f64], usize),
    ) -> Found {
        macro_rules! powers {
            ($rubbed:literal) => {
                self.instructions.run(PowersInside::<L, $rubbed> {
                    law: PhantomData,
                    part,
                    length,
                    contacts,
                    start: &path.start,
                    end: &path.end,
                    constants,
                    inverse_onset,
                    lambda,
                    floor: model.min_approach_speed,
                    friction,
                })
            };
        }
        if friction.is_some() {
            powers!(true)
        } else {
            powers!(false)
        }
    }
}

/// Return three successive arrays of `n` coordinates from `first` on.
fn columns(array: &[f64], first: usize, n: usize) -> [&[f64]; 3] {
    let (x, rest) = array[first..].split_at(n);
    let (y, rest) = rest.split_at(n);
    [x, y, &rest[..n]]
}
