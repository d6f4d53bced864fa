//! Boundary to Python: reading of descriptions, runs, results as arrays. It contains no physics.

mod arrays;
mod core;
mod describe;
mod drive_mechanism;
mod ensemble;
mod errors;
mod evaluation;
mod fmu;
mod functions;
mod integrate;
mod interrupt;
mod layouts;
mod mechanism;
mod mechanism_callable;
mod mechanism_contact;
mod mechanism_fields;
mod starts;
mod toml;

use pyo3::prelude::*;

/// Compiled module `rustchain._rustchain`.
#[pymodule]
fn _rustchain(module: &Bound<'_, PyModule>) -> PyResult<()> {
    crate::panics::keep_places();
    module.add_class::<core::Core>()?;
    module.add_class::<ensemble::Case>()?;
    module.add_class::<ensemble::Ensemble>()?;
    module.add_function(wrap_pyfunction!(mechanism::mechanism_core, module)?)?;
    module.add_function(wrap_pyfunction!(errors::panicked, module)?)?;
    module.add_function(wrap_pyfunction!(describe::validate, module)?)?;
    module.add_function(wrap_pyfunction!(functions::instruction_set, module)?)?;
    module.add_function(wrap_pyfunction!(layouts::layout, module)?)?;
    module.add_function(wrap_pyfunction!(layouts::closing_center_distance, module)?)?;
    module.add_function(wrap_pyfunction!(layouts::links_for, module)?)?;
    module.add_function(wrap_pyfunction!(layouts::static_start, module)?)?;
    module.add_function(wrap_pyfunction!(layouts::mechanism_static_start, module)?)?;
    module.add_function(wrap_pyfunction!(layouts::strand_names, module)?)?;
    module.add_function(wrap_pyfunction!(layouts::links_around, module)?)?;
    module.add_function(wrap_pyfunction!(layouts::bisector, module)?)?;
    module.add_function(wrap_pyfunction!(layouts::closing_move, module)?)?;
    module.add_function(wrap_pyfunction!(functions::tooth_outline, module)?)?;
    module.add_function(wrap_pyfunction!(functions::guide_outline, module)?)?;
    module.add_function(wrap_pyfunction!(functions::tooth_contacts, module)?)?;
    module.add_function(wrap_pyfunction!(functions::tooth_surfaces, module)?)?;
    module.add_function(wrap_pyfunction!(drive_mechanism::drive_mechanism, module)?)?;
    module.add_function(wrap_pyfunction!(functions::tooth_radii, module)?)?;
    module.add_function(wrap_pyfunction!(functions::chain_links, module)?)?;
    module.add_function(wrap_pyfunction!(functions::link_stiffness, module)?)?;
    module.add_function(wrap_pyfunction!(functions::film_forces, module)?)?;
    module.add_function(wrap_pyfunction!(functions::law_force, module)?)?;
    module.add_function(wrap_pyfunction!(functions::effective_restitution, module)?)?;
    module.add_function(wrap_pyfunction!(fmu::fmu_scene, module)?)?;
    module.add_function(wrap_pyfunction!(toml::read_toml, module)?)?;
    module.add_function(wrap_pyfunction!(integrate::integrate, module)?)
}
