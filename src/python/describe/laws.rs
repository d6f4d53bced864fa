//! Readers of the force laws of a run, their friction and lubricant film.

use pyo3::prelude::*;

use super::reader::{Reader, kind_of, number, refuse};
use crate::chain::model::ForceLaws;
use crate::error::{Error, check};
use crate::force_law::{
    Damping, Elastic, Film, ForceLaw, Friction, LuGre, Regions, Regularization,
};
use crate::multibody::{FrictionLaw, Tribology};

pub(crate) const LAWS: [&str; 9] = [
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

/// Read friction and lubricant film of a contact law.
pub(crate) fn tribology(object: &Bound<'_, PyAny>) -> PyResult<Tribology> {
    let read = Reader::of(object);
    Ok(Tribology {
        friction: read.optional("friction", friction_law)?,
        film: read.optional("film", film)?,
    })
}

/// Read an object that must be a force law.
fn law_reader<'a, 'py>(object: &'a Bound<'py, PyAny>, field: &str) -> PyResult<Reader<'a, 'py>> {
    if LAWS.contains(&kind_of(object).as_str()) {
        return Reader::new(object, field, &LAWS);
    }
    let expected = "expected a force law such as LankaraniNikravesh() or Hertz()";
    Err(refuse(field, object, expected))
}

/// Read the lubricant film of a force law, if any.
pub(super) fn film_of(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Option<Film>> {
    law_reader(object, field)?.optional("film", film)
}

/// Read a `LubricantFilm` and check it.
pub(crate) fn film(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Film> {
    let read = Reader::new(object, field, &["LubricantFilm"])?;
    let film = Film {
        viscosity: read.number("viscosity", "Pa s")?,
        length: read.optional_number("length", "m")?,
        handover: read.number("handover", "a part of the clearance")?,
        tension: read.number("tension", "Pa")?,
    };
    film.check("LubricantFilm")?;
    Ok(film)
}

/// Reject a lubricant film in a law of teeth.
fn without_film(object: &Bound<'_, PyAny>) -> PyResult<()> {
    if film_of(object, "tooth_law")?.is_some() {
        return Err(refuse(
            &format!("{}.film", kind_of(object)),
            &object.getattr("film")?,
            "must be None in tooth_law: only hinges have a film",
        ));
    }
    Ok(())
}

/// Read a force law and its friction.
pub(crate) fn law_and_friction(
    object: &Bound<'_, PyAny>,
    field: &str,
) -> PyResult<(ForceLaw, Option<FrictionLaw>)> {
    let read = law_reader(object, field)?;
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
            check::positive("Linear.stiffness", stiffness, "N/m")?;
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
    Ok((law, read.optional("friction", friction_law)?))
}

/// Read the force law of contacts in a mechanism, which have no sharp regions.
pub(crate) fn mechanism_law(object: &Bound<'_, PyAny>, field: &str) -> PyResult<ForceLaw> {
    let (law, _) = law_and_friction(object, field)?;
    if law.regions == Regions::Sharp {
        return Err(refuse(
            &format!("{}.regions", kind_of(object)),
            &object.getattr("regions")?,
            "must be \"kept\" in a mechanism, whose contacts keep the stiffness of their onset: leave it out, or simulate the drive \
             itself",
        ));
    }
    Ok(law)
}

fn coulomb(law: FrictionLaw) -> Option<Friction> {
    match law {
        FrictionLaw::Coulomb(friction) => Some(friction),
        FrictionLaw::LuGre(_) => None,
    }
}

fn bristles(law: FrictionLaw) -> Option<LuGre> {
    match law {
        FrictionLaw::Coulomb(_) => None,
        FrictionLaw::LuGre(bristles) => Some(bristles),
    }
}

/// Read a `Coulomb` or a `LuGre` and check it.
pub(crate) fn friction_law(object: &Bound<'_, PyAny>, field: &str) -> PyResult<FrictionLaw> {
    let read = Reader::new(object, field, &["Coulomb", "LuGre"])?;
    if read.kind == "LuGre" {
        lugre(object, field).map(FrictionLaw::LuGre)
    } else {
        friction(object, field).map(FrictionLaw::Coulomb)
    }
}

/// Read a `LuGre` and check it.
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
    bristles.check("LuGre")?;
    Ok(bristles)
}

/// Read a `Coulomb` and check it.
pub(crate) fn friction(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Friction> {
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
    friction.check("Coulomb")?;
    Ok(friction)
}

/// Read a damping by its name.
pub(crate) fn damping(name: &str) -> PyResult<Damping> {
    let known = Damping::ALL.into_iter().find(|law| law.name() == name);
    known.ok_or_else(|| {
        let names = Damping::ALL.map(|law| format!("\"{}\"", law.name()));
        let expected = format!("must be one of {}", names.join(", "));
        Error::invalid("damping", name, expected).into()
    })
}

/// Return the law of a kind of contacts of a `Scene`: `hinge_law` or `tooth_law`; none where it is `None`.
pub(crate) fn law_of<'py>(
    scene: &Bound<'py, PyAny>,
    field: &str,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    Ok(Some(scene.getattr(field)?).filter(|law| !law.is_none()))
}

/// Return the law of a kind of contacts of a `Scene`, or that of all contacts.
pub(crate) fn law_or_common<'py>(
    scene: &Bound<'py, PyAny>,
    field: &str,
) -> PyResult<Bound<'py, PyAny>> {
    law_of(scene, field)?.map_or_else(|| scene.getattr("force_law"), Ok)
}

/// Read and check the lower bound on impact velocities \[m/s\].
pub(crate) fn min_impact_velocity(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let least = number(value, "min_impact_velocity", "m/s")?;
    check::positive("min_impact_velocity", least, "m/s")?;
    Ok(least)
}

/// Read the laws of a run; `None` for a law of hinges or teeth selects `force_law`.
pub(crate) fn force_laws(scene: &Bound<'_, PyAny>) -> PyResult<ForceLaws> {
    let law = law_and_friction(&scene.getattr("force_law")?, "force_law")?;
    let own = |field: &str| {
        let own = law_of(scene, field)?;
        own.map_or(Ok(law), |own| law_and_friction(&own, field))
    };
    let (hinge, hinge_friction) = own("hinge_law")?;
    let (tooth, tooth_friction) = own("tooth_law")?;
    let hinge_film = film_of(&law_or_common(scene, "hinge_law")?, "hinge_law")?;
    if let Some(own) = law_of(scene, "tooth_law")? {
        without_film(&own)?;
    }
    let least = min_impact_velocity(&scene.getattr("min_impact_velocity")?)?;
    Ok(ForceLaws {
        hinge,
        tooth,
        hinge_friction: hinge_friction.and_then(coulomb),
        tooth_friction: tooth_friction.and_then(coulomb),
        hinge_bristles: hinge_friction.and_then(bristles),
        tooth_bristles: tooth_friction.and_then(bristles),
        hinge_film,
        min_impact_velocity: least,
    })
}
