//! Python's frozen dataclasses -> the descriptions of this crate, field by field.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyString, PyTuple};

use super::errors::{InvalidInput, to_python};
use crate::drive::{
    AnsiTooth, Arm, Bearing, Chain, ChainEnd, ClearanceHinge, CustomTooth, Drive, Faults, IsoTooth,
    Link, Material, Motion, Mount, Rail, RailShape, Roller, Sprocket, StraightTooth, Tensioner,
    TimeTable, Tip, ToothForm, Variation,
};
use crate::error::{Error, Result, check};
use crate::force_law::{
    Damping, Elastic, Film, ForceLaw, Friction, LuGre, Regions, Regularization,
};
use crate::geometry::belt::Side;
use crate::geometry::{Damage, OutlinePiece, Seat, Vec2};
use crate::integrator::{Corrector, StepControl};
use crate::model::ForceLaws;
use crate::recorder::Groups;
use crate::simulate::check_reports;

/// One description object, whose fields are read by name.
pub(super) struct Reader<'a, 'py> {
    object: &'a Bound<'py, PyAny>,
    pub(super) kind: String,
}

impl<'a, 'py> Reader<'a, 'py> {
    /// Reads `object`, which must be a description of one of the `kinds`.
    pub(super) fn new(
        object: &'a Bound<'py, PyAny>,
        field: &str,
        kinds: &[&str],
    ) -> PyResult<Self> {
        let kind = kind_of(object);
        if kinds.contains(&kind.as_str()) {
            return Ok(Self { object, kind });
        }
        Err(refuse(
            object.py(),
            field,
            object,
            &format!("must be a {}", kinds.join(" or a ")),
        ))
    }

    fn name(&self, field: &str) -> String {
        format!("{}.{field}", self.kind)
    }

    pub(super) fn get(&self, field: &str) -> PyResult<Bound<'py, PyAny>> {
        self.object.getattr(field)
    }

    pub(super) fn number(&self, field: &str, unit: &str) -> PyResult<f64> {
        number(&self.get(field)?, &self.name(field), unit)
    }

    pub(super) fn optional_number(&self, field: &str, unit: &str) -> PyResult<Option<f64>> {
        let value = self.get(field)?;
        if value.is_none() {
            return Ok(None);
        }
        number(&value, &self.name(field), unit).map(Some)
    }

    /// A name for people to read: nothing here uses it, but it has to be text.
    fn check_text(&self, field: &str) -> PyResult<()> {
        let value = self.get(field)?;
        if value.is_instance_of::<PyString>() {
            return Ok(());
        }
        Err(refuse(
            value.py(),
            &self.name(field),
            &value,
            "must be text",
        ))
    }

    /// A number, or a row of them.
    fn numbers(&self, field: &str, unit: &str) -> PyResult<Vec<f64>> {
        let value = self.get(field)?;
        let name = self.name(field);
        let Ok(row) = value.cast::<PyTuple>() else {
            return Ok(vec![number(&value, &name, unit)?]);
        };
        row.iter().map(|each| number(&each, &name, unit)).collect()
    }

    fn count(&self, field: &str) -> PyResult<u32> {
        count(&self.get(field)?, &self.name(field))
    }

    pub(super) fn vector(&self, field: &str, unit: &str) -> PyResult<Vec2> {
        let value = self.get(field)?;
        if let Ok(pair) = value.cast::<PyTuple>()
            && pair.len() == 2
        {
            let name = self.name(field);
            return Ok(Vec2::new(
                number(&pair.get_item(0)?, &format!("{name} (x)"), unit)?,
                number(&pair.get_item(1)?, &format!("{name} (y)"), unit)?,
            ));
        }
        Err(refuse(
            value.py(),
            &self.name(field),
            &value,
            &match unit {
                "1" => "must be two numbers (x, y)".to_string(),
                unit => format!("must be two numbers (x, y) in {unit}"),
            },
        ))
    }

    fn optional_vector(&self, field: &str, unit: &str) -> PyResult<Option<Vec2>> {
        if self.get(field)?.is_none() {
            return Ok(None);
        }
        self.vector(field, unit).map(Some)
    }

    /// One of several words, each standing for a value; `None` in Python is the word "None".
    pub(super) fn word<T: Copy>(&self, field: &str, words: &[(&str, T)]) -> PyResult<T> {
        let value = self.get(field)?;
        let text = if value.is_none() {
            "None".to_string()
        } else {
            value.extract::<String>().unwrap_or_default()
        };
        if let Some((_, found)) = words.iter().find(|(word, _)| *word == text) {
            return Ok(*found);
        }
        let allowed: Vec<String> = words
            .iter()
            .map(|(word, _)| {
                if *word == "None" {
                    "None".to_string()
                } else {
                    format!("\"{word}\"")
                }
            })
            .collect();
        Err(refuse(
            value.py(),
            &self.name(field),
            &value,
            &format!("must be {}", allowed.join(" or ")),
        ))
    }

    fn table(&self, field: &str, unit: &str) -> PyResult<TimeTable> {
        self.table_against(field, ("time", "s"), unit)
    }

    /// A constant, or rows of (axis, value).
    fn table_against(&self, field: &str, axis: (&str, &str), unit: &str) -> PyResult<TimeTable> {
        table(&self.get(field)?, &self.name(field), axis, unit)
    }
}

/// A constant, or a tuple of rows (axis, value).
pub(super) fn table(
    value: &Bound<'_, PyAny>,
    name: &str,
    axis: (&str, &str),
    unit: &str,
) -> PyResult<TimeTable> {
    let expected = format!("each row must be ({}, value)", axis.0);
    let Ok(rows) = value.cast::<PyTuple>() else {
        let constant = number(value, name, unit)?;
        return checked(
            value.py(),
            crate::error::check::finite(name, constant, unit).map(|()| constant.into()),
        );
    };
    let mut pairs = Vec::new();
    for row in rows {
        let Ok(pair) = row.cast::<PyTuple>() else {
            return Err(refuse(row.py(), name, &row, &expected));
        };
        if pair.len() != 2 {
            return Err(refuse(row.py(), name, &row, &expected));
        }
        pairs.push((
            number(&pair.get_item(0)?, &format!("{name} ({})", axis.0), axis.1)?,
            number(&pair.get_item(1)?, &format!("{name} (value)"), unit)?,
        ));
    }
    checked(value.py(), TimeTable::against(name, axis, unit, &pairs))
}

fn kind_of(object: &Bound<'_, PyAny>) -> String {
    object
        .get_type()
        .name()
        .map(|n| n.to_string())
        .unwrap_or_default()
}

/// A finite number.
pub(super) fn finite(value: &Bound<'_, PyAny>, field: &str, unit: &str) -> PyResult<f64> {
    let found = number(value, field, unit)?;
    checked(value.py(), crate::error::check::finite(field, found, unit)).map(|()| found)
}

/// True or False.
pub(super) fn truth(value: &Bound<'_, PyAny>, field: &str) -> PyResult<bool> {
    value
        .extract()
        .map_err(|_| refuse(value.py(), field, value, "must be True or False"))
}

/// A whole number, not negative.
pub(super) fn count(value: &Bound<'_, PyAny>, field: &str) -> PyResult<u32> {
    if !value.is_instance_of::<PyBool>()
        && let Ok(count) = value.extract::<u32>()
    {
        return Ok(count);
    }
    Err(refuse(
        value.py(),
        field,
        value,
        "must be a whole number, not negative",
    ))
}

/// The numbers of teeth of two sprockets.
pub(super) fn two_teeth(value: &Bound<'_, PyAny>) -> PyResult<[u32; 2]> {
    if let Ok([first, second]) = value.extract::<[Bound<'_, PyAny>; 2]>()
        && let (Ok(first), Ok(second)) = (count(&first, "teeth"), count(&second, "teeth"))
        && [first, second].iter().all(|n| (5..=1000).contains(n))
    {
        return Ok([first, second]);
    }
    Err(refuse(
        value.py(),
        "teeth",
        value,
        "must be two whole numbers between 5 and 1000",
    ))
}

/// A number, which may be infinite or NaN.
pub(super) fn number(value: &Bound<'_, PyAny>, field: &str, unit: &str) -> PyResult<f64> {
    if !value.is_instance_of::<PyBool>()
        && !value.is_instance_of::<PyString>()
        && let Ok(number) = value.extract::<f64>()
    {
        return Ok(number);
    }
    let expected = if unit == "1" {
        "must be a number".to_string()
    } else {
        format!("must be a number in {unit}")
    };
    Err(refuse(value.py(), field, value, &expected))
}

pub(super) fn refuse(
    py: Python<'_>,
    field: &str,
    value: &Bound<'_, PyAny>,
    expected: &str,
) -> PyErr {
    let shown = value.repr().map(|r| r.to_string()).unwrap_or_default();
    to_python(py, &Error::invalid(field, shown, expected))
}

pub(super) fn checked<T>(py: Python<'_>, result: Result<T>) -> PyResult<T> {
    result.map_err(|error| to_python(py, &error))
}

pub(super) fn material(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Material> {
    let read = Reader::new(object, field, &["Material"])?;
    Ok(Material {
        elastic_modulus: read.number("elastic_modulus", "Pa")?,
        poisson_ratio: read.number("poisson_ratio", "1")?,
        restitution: read.number("restitution", "1")?,
    })
}

fn link(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Link> {
    let read = Reader::new(object, field, &["Link"])?;
    Ok(Link {
        mass: read.number("mass", "kg")?,
        inertia: read.number("inertia", "kg m^2")?,
    })
}

fn hinge(object: &Bound<'_, PyAny>, field: &str) -> PyResult<ClearanceHinge> {
    let read = Reader::new(object, field, &["ClearanceHinge"])?;
    Ok(ClearanceHinge {
        pin_radius: read.number("pin_radius", "m")?,
        bore_radius: read.number("bore_radius", "m")?,
        length: read.number("length", "m")?,
    })
}

fn roller(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Roller> {
    let read = Reader::new(object, field, &["Roller"])?;
    Ok(Roller {
        radius: read.number("radius", "m")?,
        bore_radius: read.number("bore_radius", "m")?,
        length: read.number("length", "m")?,
        mass: read.number("mass", "kg")?,
        inertia: read.number("inertia", "kg m^2")?,
    })
}

pub(super) fn chain(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Chain> {
    let read = Reader::new(object, field, &["Chain"])?;
    read.check_text("name")?;
    Ok(Chain {
        pitch: read.number("pitch", "m")?,
        links: read.count("links")?,
        inner: link(&read.get("inner")?, "Chain.inner")?,
        outer: link(&read.get("outer")?, "Chain.outer")?,
        hinge: hinge(&read.get("hinge")?, "Chain.hinge")?,
        bushing_radius: read.number("bushing_radius", "m")?,
        tooth_contact_length: read.number("tooth_contact_length", "m")?,
        material: material(&read.get("material")?, "Chain.material")?,
        offset: {
            let offset = read.get("offset")?;
            if offset.is_none() {
                None
            } else {
                Some(link(&offset, "Chain.offset")?)
            }
        },
        strands: read.count("strands")?,
        variation: Variation {
            elongation: read.numbers("elongation", "1")?,
            pitch_spread: read.number("pitch_spread", "1")?,
            seed: u64::from(read.count("seed")?),
        },
        roller: {
            let given = read.get("roller")?;
            if given.is_none() {
                None
            } else {
                Some(roller(&given, "Chain.roller")?)
            }
        },
        link_stiffness: read.optional_number("link_stiffness", "N/m")?,
    })
}

const FORMS: [&str; 4] = ["AnsiTooth", "IsoTooth", "StraightTooth", "CustomTooth"];

fn seat(read: &Reader<'_, '_>) -> PyResult<Seat> {
    read.word(
        "seat",
        &[
            ("bottom-diameter", Seat::BottomDiameter),
            ("pitch-circle", Seat::PitchCircle),
        ],
    )
}

fn tooth_form(object: &Bound<'_, PyAny>, field: &str) -> PyResult<ToothForm> {
    let read = Reader::new(object, field, &FORMS)?;
    let edge_radius = read.optional_number("edge_radius", "m")?;
    Ok(match read.kind.as_str() {
        "AnsiTooth" => ToothForm::Ansi(AnsiTooth {
            seat: seat(&read)?,
            roller_diameter: read.optional_number("roller_diameter", "m")?,
            tip: read.word("tip", &[("full", Tip::Full), ("cut", Tip::Cut)])?,
            edge_radius,
        }),
        "IsoTooth" => ToothForm::Iso(IsoTooth {
            gap: iso_gap(&read)?,
            seat: seat(&read)?,
            roller_diameter: read.optional_number("roller_diameter", "m")?,
            tip_diameter: read.optional_number("tip_diameter", "m")?,
            edge_radius,
        }),
        "StraightTooth" => ToothForm::Straight(StraightTooth {
            flank_angle: read.number("flank_angle", "rad")?,
            seat_radius: read.optional_number("seat_radius", "m")?,
            seat: seat(&read)?,
            roller_diameter: read.optional_number("roller_diameter", "m")?,
            tip_diameter: read.optional_number("tip_diameter", "m")?,
            edge_radius,
        }),
        _ => ToothForm::Custom(CustomTooth {
            pieces: outline(&read)?,
            tip_diameter: read.optional_number("tip_diameter", "m")?,
            edge_radius,
        }),
    })
}

/// A share of the way from the minimum gap to the maximum one, or one of the two by name.
fn iso_gap(read: &Reader<'_, '_>) -> PyResult<f64> {
    let gap = read.get("gap")?;
    if gap.is_instance_of::<PyString>() {
        return read.word("gap", &[("minimum", 0.0), ("maximum", 1.0)]);
    }
    number(&gap, "IsoTooth.gap", "1")
}

fn outline(read: &Reader<'_, '_>) -> PyResult<Vec<OutlinePiece>> {
    let pieces = read.get("pieces")?;
    let Ok(pieces) = pieces.cast::<PyTuple>() else {
        let expected = "must be a sequence of ToothLine and ToothArc";
        return Err(refuse(pieces.py(), "CustomTooth.pieces", &pieces, expected));
    };
    let piece = |(i, piece): (usize, Bound<'_, PyAny>)| {
        let field = format!("CustomTooth.pieces[{i}]");
        outline_piece(&piece, &field)
    };
    pieces.iter().enumerate().map(piece).collect()
}

fn outline_piece(object: &Bound<'_, PyAny>, field: &str) -> PyResult<OutlinePiece> {
    let read = Reader::new(object, field, &["ToothLine", "ToothArc"])?;
    Ok(OutlinePiece {
        start: read.vector("start", "m")?,
        end: read.vector("end", "m")?,
        center: if read.kind == "ToothArc" {
            Some(read.vector("center", "m")?)
        } else {
            None
        },
    })
}

/// Rows (number of a tooth, share of its height that is left).
fn damage(read: &Reader<'_, '_>) -> PyResult<Vec<Damage>> {
    const NAME: &str = "Sprocket.damaged_teeth";
    let rows = read.get("damaged_teeth")?;
    let wrong = |value: &Bound<'_, PyAny>| {
        let expected =
            "must be rows (number of the tooth from 0, share of its height that is left)";
        refuse(value.py(), NAME, value, expected)
    };
    let Ok(rows) = rows.cast::<PyTuple>() else {
        return Err(wrong(&rows));
    };
    let row = |row: Bound<'_, PyAny>| {
        let Ok([tooth, height]) = row.extract::<[Bound<'_, PyAny>; 2]>() else {
            return Err(wrong(&row));
        };
        Ok(Damage {
            tooth: count(&tooth, NAME)?,
            height: number(&height, NAME, "1")?,
        })
    };
    rows.iter().map(row).collect()
}

fn motion(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Motion> {
    let read = Reader::new(object, field, &["PrescribedSpeed", "AppliedTorque", "Free"])?;
    Ok(match read.kind.as_str() {
        "PrescribedSpeed" => Motion::PrescribedSpeed(read.table("speed", "rad/s")?),
        "AppliedTorque" => {
            let torque = read.table("torque", "N m")?;
            if read.get("curve")?.is_none() {
                Motion::AppliedTorque(torque)
            } else {
                let curve = read.table_against("curve", ("speed", "rad/s"), "N m")?;
                Motion::TorqueCurve { torque, curve }
            }
        }
        _ => Motion::Free,
    })
}

pub(super) fn sprocket(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Sprocket> {
    let read = Reader::new(object, field, &["Sprocket"])?;
    Ok(Sprocket {
        teeth: read.count("teeth")?,
        center: read.vector("center", "m")?,
        motion: motion(&read.get("motion")?, "Sprocket.motion")?,
        profile: tooth_form(&read.get("profile")?, "Sprocket.profile")?,
        faults: Faults {
            eccentricity: read.number("eccentricity", "m")?,
            eccentricity_angle: read.number("eccentricity_angle", "rad")?,
            damage: damage(&read)?,
        },
        mass: read.optional_number("mass", "kg")?,
        inertia: read.optional_number("inertia", "kg m^2")?,
        initial_speed: read.optional_number("initial_speed", "rad/s")?,
        bearing: read.word(
            "bearing",
            &[("fixed", Bearing::Fixed), ("floating", Bearing::Floating)],
        )?,
        side: read.word(
            "side",
            &[("inside", Side::Inside), ("outside", Side::Outside)],
        )?,
        load_inertia: read.number("load_inertia", "kg m^2")?,
    })
}

fn tensioner(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Tensioner> {
    let read = Reader::new(object, field, &["Tensioner"])?;
    Ok(Tensioner {
        sprocket: read.count("sprocket")? as usize,
        pretension: read.number("pretension", "N")?,
        ramp_time: read.number("ramp_time", "s")?,
        damping: read.number("damping", "N s/m")?,
        damping_back: read.optional_number("damping_back", "N s/m")?,
        direction: read.optional_vector("direction", "1")?,
        stiffness: read.number("stiffness", "N/m")?,
        travel: if read.get("travel")?.is_none() {
            [f64::INFINITY; 2]
        } else {
            read.vector("travel", "m")?.into()
        },
        pivot: read.optional_vector("pivot", "m")?,
        arm_inertia: read.number("arm_inertia", "kg m^2")?,
        ratchet: read.optional_number("ratchet", "m")?,
    })
}

fn arm(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Arm> {
    let read = Reader::new(object, field, &["GuideArm"])?;
    Ok(Arm {
        pivot: read.vector("pivot", "m")?,
        force: read.number("force", "N")?,
        ramp_time: read.number("ramp_time", "s")?,
        stiffness: read.number("stiffness", "N/m")?,
        damping: read.number("damping", "N s/m")?,
        damping_back: read.optional_number("damping_back", "N s/m")?,
        travel: if read.get("travel")?.is_none() {
            [f64::INFINITY; 2]
        } else {
            read.vector("travel", "m")?.into()
        },
        inertia: read.number("inertia", "kg m^2")?,
        ratchet: read.optional_number("ratchet", "m")?,
    })
}

pub(super) fn rail(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Rail> {
    let read = Reader::new(object, field, &["GuideRail", "SmoothIdler"])?;
    let own = read.get("material")?;
    let of = if own.is_none() {
        None
    } else {
        Some(material(&own, &read.name("material"))?)
    };
    let center = read.vector("center", "m")?;
    if read.kind == "SmoothIdler" {
        return Ok(Rail {
            shape: RailShape::Wheel {
                radius: read.number("radius", "m")?,
            },
            center,
            direction: Vec2::x(),
            mount: read
                .optional_number("inertia", "kg m^2")?
                .map_or(Mount::Fixed, |inertia| Mount::Turning { inertia }),
            material: of,
            plate_height: read.optional_number("plate_height", "m")?,
        });
    }
    let swung = read.get("arm")?;
    Ok(Rail {
        shape: RailShape::Bar {
            length: read.number("length", "m")?,
            radius: read.optional_number("radius", "m")?,
            end_radius: read.number("end_radius", "m")?,
        },
        center,
        direction: read.vector("direction", "1")?,
        mount: if swung.is_none() {
            Mount::Fixed
        } else {
            Mount::Arm(arm(&swung, "GuideRail.arm")?)
        },
        material: of,
        plate_height: read.optional_number("plate_height", "m")?,
    })
}

const ENDS: [&str; 3] = ["Anchor", "Load", "LooseEnd"];
/// Density of the steel that a load is a ball of, where its inertia is not given \[kg/m³\].
const STEEL: f64 = 7850.0;

/// Reads an end of an open chain.
pub(super) fn chain_end(object: &Bound<'_, PyAny>, field: &str) -> PyResult<ChainEnd> {
    let read = Reader::new(object, field, &ENDS)?;
    let links = if read.get("links")?.is_none() {
        None
    } else {
        Some(read.count("links")?)
    };
    Ok(match read.kind.as_str() {
        "Anchor" => ChainEnd::Anchor {
            position: read.vector("position", "m")?,
            velocity: end_velocity(&read)?,
            links,
        },
        "Load" => {
            let mass = read.number("mass", "kg")?;
            let ball = |mass: f64| {
                let radius = (mass / (STEEL * 4.0 / 3.0 * std::f64::consts::PI)).cbrt();
                0.4 * mass * radius * radius
            };
            ChainEnd::Load {
                mass,
                inertia: read
                    .optional_number("inertia", "kg m^2")?
                    .unwrap_or_else(|| ball(mass)),
                arm: read.number("arm", "m")?,
                position: read.optional_vector("position", "m")?,
                links,
            }
        }
        _ => ChainEnd::Loose {
            position: read.optional_vector("position", "m")?,
            links,
        },
    })
}

/// A constant velocity, or rows (time, x, y).
fn end_velocity(read: &Reader<'_, '_>) -> PyResult<[TimeTable; 2]> {
    let value = read.get("velocity")?;
    let is_table = |rows: &Bound<'_, PyTuple>| {
        rows.get_item(0)
            .is_ok_and(|row| row.is_instance_of::<PyTuple>())
    };
    let Some(rows) = value.cast::<PyTuple>().ok().filter(|rows| is_table(rows)) else {
        let [x, y]: [f64; 2] = read.vector("velocity", "m/s")?.into();
        return [x, y]
            .map(|constant| {
                checked(
                    value.py(),
                    check::finite("Anchor.velocity", constant, "m/s"),
                )
                .map(|()| constant.into())
            })
            .into_iter()
            .collect::<PyResult<Vec<TimeTable>>>()
            .map(|mut both| [both.remove(0), both.remove(0)]);
    };
    let mut both = [Vec::new(), Vec::new()];
    for row in rows {
        let Ok([t, x, y]) = row.extract::<[f64; 3]>() else {
            let expected = "each row must be (time, x, y) in s and m/s";
            return Err(refuse(row.py(), "Anchor.velocity", &row, expected));
        };
        both[0].push((t, x));
        both[1].push((t, y));
    }
    let table = |rows: &[(f64, f64)]| {
        let made = TimeTable::against("Anchor.velocity", ("time", "s"), "m/s", rows);
        checked(value.py(), made)
    };
    Ok([table(&both[0])?, table(&both[1])?])
}

/// Reads the two ends of an open chain.
fn chain_ends(read: &Reader<'_, '_>) -> PyResult<Option<[ChainEnd; 2]>> {
    let value = read.get("ends")?;
    if value.is_none() {
        return Ok(None);
    }
    let Ok([first, last]) = value.extract::<[Bound<'_, PyAny>; 2]>() else {
        let expected = "must be None, or two of Anchor, Load and LooseEnd";
        return Err(refuse(value.py(), "ChainDrive.ends", &value, expected));
    };
    Ok(Some([
        chain_end(&first, "ChainDrive.ends[0]")?,
        chain_end(&last, "ChainDrive.ends[1]")?,
    ]))
}

/// Reads a `ChainDrive`, unchecked.
pub(super) fn drive(object: &Bound<'_, PyAny>) -> PyResult<Drive> {
    let read = Reader::new(object, "drive", &["ChainDrive"])?;
    read.check_text("name")?;
    let sprockets = read.get("sprockets")?;
    let Ok(sprockets) = sprockets.cast::<PyTuple>() else {
        return Err(refuse(
            object.py(),
            "ChainDrive.sprockets",
            &sprockets,
            "must be a sequence of Sprocket",
        ));
    };
    let guides = read.get("guides")?;
    let Ok(guides) = guides.cast::<PyTuple>() else {
        return Err(refuse(
            object.py(),
            "ChainDrive.guides",
            &guides,
            "must be a sequence of GuideRail and SmoothIdler",
        ));
    };
    let tight = read.get("tensioner")?;
    // Ideal hinges make the drive a mechanism, which is put together in Python.
    read.word("hinges", &[("clearance", ()), ("ideal", ())])?;
    Ok(Drive {
        chain: chain(&read.get("chain")?, "ChainDrive.chain")?,
        sprockets: sprockets
            .iter()
            .enumerate()
            .map(|(i, s)| sprocket(&s, &format!("ChainDrive.sprockets[{i}]")))
            .collect::<PyResult<_>>()?,
        tensioner: if tight.is_none() {
            None
        } else {
            Some(tensioner(&tight, "ChainDrive.tensioner")?)
        },
        gravity: read.vector("gravity", "m/s^2")?,
        guides: guides
            .iter()
            .enumerate()
            .map(|(i, guide)| rail(&guide, &format!("ChainDrive.guides[{i}]")))
            .collect::<PyResult<_>>()?,
        ends: chain_ends(&read)?,
    })
}

const LAWS: [&str; 9] = [
    "LankaraniNikravesh",
    "Hertz",
    "Johnson",
    "EnhancedCylinder",
    "HertzCylinder",
    "Radzimovsky",
    "Esdu78035",
    "LiuConformal",
    "Linear",
];

/// Reads a force law of a contact that has neither friction nor film.
pub(super) fn force_law(object: &Bound<'_, PyAny>, field: &str) -> PyResult<ForceLaw> {
    let (law, friction) = law_and_friction(object, field)?;
    if friction.is_some() {
        return Err(refuse(
            object.py(),
            &format!("{}.friction", kind_of(object)),
            &object.getattr("friction")?,
            "must be None here: only chain drives with clearance hinges have friction",
        ));
    }
    let remedy = "must be None here: only chain drives with clearance hinges have a film";
    without_film(object, field, remedy)?;
    Ok(law)
}

/// Reads the film of a force law, if it has one.
fn film_of(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Option<Film>> {
    let fills = Reader::new(object, field, &LAWS)?.get("film")?;
    if fills.is_none() {
        return Ok(None);
    }
    film(&fills, &format!("{}.film", kind_of(object))).map(Some)
}

/// Reads a `Film` and checks it.
pub(super) fn film(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Film> {
    let read = Reader::new(object, field, &["Film"])?;
    let film = Film {
        viscosity: read.number("viscosity", "Pa s")?,
        length: read.optional_number("length", "m")?,
        handover: read.number("handover", "a part of the clearance")?,
        tension: read.number("tension", "Pa")?,
    };
    checked(object.py(), film.check("Film"))?;
    Ok(film)
}

/// Refuses a film where there can be none.
fn without_film(object: &Bound<'_, PyAny>, field: &str, remedy: &str) -> PyResult<()> {
    if film_of(object, field)?.is_some() {
        return Err(refuse(
            object.py(),
            &format!("{}.film", kind_of(object)),
            &object.getattr("film")?,
            remedy,
        ));
    }
    Ok(())
}

/// Reads a force law and its friction.
pub(super) fn law_and_friction(
    object: &Bound<'_, PyAny>,
    field: &str,
) -> PyResult<(ForceLaw, Option<Rubbing>)> {
    let read = Reader::new(object, field, &LAWS)?;
    let elastic = match read.kind.as_str() {
        "EnhancedCylinder" => read.word(
            "coefficients",
            &[
                ("2010", Elastic::EnhancedCylinder),
                ("2015", Elastic::EnhancedCylinder2015),
            ],
        )?,
        "Linear" => {
            let stiffness = read.number("stiffness", "N/m")?;
            let allowed = check::positive("Linear.stiffness", stiffness, "N/m");
            checked(object.py(), allowed)?;
            Elastic::Linear(stiffness)
        }
        _ => read.word("elastic", &Elastic::ALL.map(|law| (law.name(), law)))?,
    };
    let mut dampings = Damping::ALL.map(|law| (law.name(), law)).to_vec();
    dampings.push((Damping::None.name(), Damping::None));
    let law = ForceLaw {
        elastic,
        damping: read.word("damping", &dampings)?,
        regions: read.word(
            "regions",
            &[("kept", Regions::Kept), ("sharp", Regions::Sharp)],
        )?,
    };
    let rubs = read.get("friction")?;
    let name = format!("{}.friction", read.kind);
    let friction = (!rubs.is_none()).then(|| rubbing(&rubs, &name));
    Ok((law, friction.transpose()?))
}

/// The friction of a contact: of the slip speed, or of bristles.
#[derive(Clone, Copy)]
pub(super) enum Rubbing {
    Coulomb(Friction),
    LuGre(LuGre),
}

impl Rubbing {
    fn coulomb(self) -> Option<Friction> {
        match self {
            Self::Coulomb(friction) => Some(friction),
            Self::LuGre(_) => None,
        }
    }

    fn bristles(self) -> Option<LuGre> {
        match self {
            Self::Coulomb(_) => None,
            Self::LuGre(bristles) => Some(bristles),
        }
    }
}

/// Reads a `Coulomb` or a `LuGre` and checks it.
fn rubbing(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Rubbing> {
    let read = Reader::new(object, field, &["Coulomb", "LuGre"])?;
    if read.kind == "LuGre" {
        lugre(object, field).map(Rubbing::LuGre)
    } else {
        friction(object, field).map(Rubbing::Coulomb)
    }
}

/// Reads a `LuGre` and checks it.
fn lugre(object: &Bound<'_, PyAny>, field: &str) -> PyResult<LuGre> {
    let read = Reader::new(object, field, &["LuGre"])?;
    let bristles = LuGre {
        static_coefficient: read.number("static_coefficient", "newton a newton")?,
        kinetic_coefficient: read.number("kinetic_coefficient", "newton a newton")?,
        stiffness: read.number("stiffness", "1/m")?,
        damping: read.number("damping", "s/m")?,
        viscous_coefficient: read.number("viscous_coefficient", "s/m")?,
        stribeck_speed: read.number("stribeck_speed", "m/s")?,
        stribeck_exponent: read.number("stribeck_exponent", "powers of the speed")?,
    };
    checked(object.py(), bristles.check("LuGre"))?;
    Ok(bristles)
}

/// Reads a `Coulomb` and checks it.
fn friction(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Friction> {
    let read = Reader::new(object, field, &["Coulomb"])?;
    let friction = Friction {
        coefficient: read.number("coefficient", "newton a newton")?,
        regularization: read.word(
            "regularization",
            &Regularization::ALL.map(|law| (law.name(), law)),
        )?,
        speed: read.number("speed", "m/s")?,
        dead_speed: read.number("dead_speed", "m/s")?,
    };
    checked(object.py(), friction.check("Coulomb"))?;
    Ok(friction)
}

/// Reads a damping by its name.
pub(super) fn damping(name: &str, py: Python<'_>) -> PyResult<Damping> {
    let known = Damping::ALL.into_iter().find(|law| law.name() == name);
    known.ok_or_else(|| {
        let names = Damping::ALL.map(|law| format!("\"{}\"", law.name()));
        let expected = format!("must be one of {}", names.join(", "));
        to_python(py, &Error::invalid("damping", name, expected))
    })
}

/// Reads the laws of a run; `None`: as `force_law`.
pub(super) fn force_laws(
    force_law: &Bound<'_, PyAny>,
    hinge_law: Option<&Bound<'_, PyAny>>,
    tooth_law: Option<&Bound<'_, PyAny>>,
    min_approach_speed: &Bound<'_, PyAny>,
) -> PyResult<ForceLaws> {
    let law = law_and_friction(force_law, "force_law")?;
    let own = |own: Option<&Bound<'_, PyAny>>, field: &str| {
        own.map_or(Ok(law), |own| law_and_friction(own, field))
    };
    let (hinge, hinge_friction) = own(hinge_law, "hinge_law")?;
    let (tooth, tooth_friction) = own(tooth_law, "tooth_law")?;
    let hinge_film = film_of(hinge_law.unwrap_or(force_law), "hinge_law")?;
    if let Some(own) = tooth_law {
        let remedy = "must be None in tooth_law: only hinges have a film";
        without_film(own, "tooth_law", remedy)?;
    }
    Ok(ForceLaws {
        hinge,
        tooth,
        hinge_friction: hinge_friction.and_then(Rubbing::coulomb),
        tooth_friction: tooth_friction.and_then(Rubbing::coulomb),
        hinge_bristles: hinge_friction.and_then(Rubbing::bristles),
        tooth_bristles: tooth_friction.and_then(Rubbing::bristles),
        hinge_film,
        min_approach_speed: number(min_approach_speed, "min_approach_speed", "m/s")?,
    })
}

/// Reads and checks what to record: duration \[s\], time between two rows \[s\], and the groups by their names.
pub(super) fn reports(
    duration: &Bound<'_, PyAny>,
    report_step: &Bound<'_, PyAny>,
    groups: &[String],
    energy: &Bound<'_, PyAny>,
) -> PyResult<(f64, f64, Groups)> {
    let py = duration.py();
    let duration = number(duration, "duration", "s")?;
    let report_step = number(report_step, "report_step", "s")?;
    let energy = truth(energy, "energy")?;
    checked(py, check_reports(duration, report_step))?;
    let has = |name: &str| groups.iter().any(|g| g == name);
    let groups = Groups {
        hinges: has("hinges"),
        teeth: has("teeth"),
        sprockets: has("sprockets"),
        bodies: has("bodies"),
        energy,
    };
    Ok((duration, report_step, groups))
}

/// What one of `rtol` and `atol` is where only the other is given.
const DEFAULT_TOLERANCE: f64 = 1e-5;

/// Reads a `Solver` and checks it.
pub(super) fn solver(object: &Bound<'_, PyAny>) -> PyResult<StepControl> {
    let read = Reader::new(object, "solver", &["Solver"])?;
    let corrector = read.word(
        "method",
        &[
            ("auto", Corrector::Auto),
            ("pece", Corrector::Pece),
            ("newton", Corrector::Newton),
        ],
    )?;
    let rtol = read.optional_number("rtol", "relative units")?;
    let atol = read.optional_number("atol", "the unit of each component")?;
    if rtol.unwrap_or(DEFAULT_TOLERANCE) == 0.0 && atol.unwrap_or(DEFAULT_TOLERANCE) == 0.0 {
        let expected = "rtol and atol must not both be zero; None for both lets accuracy rule";
        let refusal = Error::invalid("Solver.atol", 0.0, expected);
        checked(object.py(), Err(refusal))?;
    }
    let given = rtol.is_some() || atol.is_some();
    let tolerance =
        |value: Option<f64>| value.unwrap_or(if given { DEFAULT_TOLERANCE } else { 0.0 });
    let control = StepControl {
        rtol: tolerance(rtol),
        atol: tolerance(atol),
        max_step: read.number("max_step", "s")?,
        max_order: read.count("max_order")? as usize,
        corrector,
        accuracy: read.number("accuracy", "m")?,
    };
    checked(object.py(), control.validate())?;
    Ok(control)
}

/// Raises `InvalidInput` when a field of a description is not allowed.
#[pyfunction]
pub(super) fn validate(description: &Bound<'_, PyAny>) -> PyResult<()> {
    let object = description;
    let outcome = match kind_of(object).as_str() {
        "Material" => material(object, "")?.validate(),
        "Link" => link(object, "")?.validate(),
        "ClearanceHinge" => hinge(object, "")?.validate(),
        "Roller" => roller(object, "")?.validate(),
        "Chain" => chain(object, "")?.validate(),
        kind if FORMS.contains(&kind) => tooth_form(object, "")?.validate(),
        "ToothLine" | "ToothArc" => outline_piece(object, "").map(|_| Ok(()))?,
        "PrescribedSpeed" | "AppliedTorque" | "Free" => motion(object, "").map(|_| Ok(()))?,
        "Sprocket" => sprocket(object, "")?.validate(),
        "Tensioner" => tensioner(object, "")?.validate(),
        "GuideArm" => arm(object, "")?.validate(),
        "GuideRail" | "SmoothIdler" => rail(object, "guide")?.validate(),
        kind if ENDS.contains(&kind) => chain_end(object, "")?.validate(),
        "ChainDrive" => drive(object)?.validate(),
        "Solver" => solver(object).map(|_| Ok(()))?,
        kind if LAWS.contains(&kind) => {
            film_of(object, "")?;
            law_and_friction(object, "").map(|_| Ok(()))?
        }
        "Coulomb" | "LuGre" => rubbing(object, "").map(|_| Ok(()))?,
        "Film" => film(object, "").map(|_| Ok(()))?,
        kind => {
            return Err(InvalidInput::new_err(format!(
                "{kind} is not a description that this version knows"
            )));
        }
    };
    checked(object.py(), outcome)
}
