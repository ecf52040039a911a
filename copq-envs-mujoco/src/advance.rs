//! Moving a simulation, and finding out whether MuJoCo is content with it.

use crate::simulation::{Array, Call, Simulation};

/// Resets the data, takes a state and evaluates the model there.
pub(crate) fn place(
    simulation: &mut dyn Simulation,
    qpos: &[f64],
    qvel: &[f64],
) -> Result<(), String> {
    simulation.call(Call::Reset, 1)?;
    simulation.array_mut(Array::Qpos).copy_from_slice(qpos);
    simulation.array_mut(Array::Qvel).copy_from_slice(qvel);
    simulation.call(Call::Forward, 1)?;
    complaint(simulation).map_or(Ok(()), Err)
}

/// Takes timesteps with the controls held, and with the damping that MuJoCo leaves to us.
pub(crate) fn advance(
    simulation: &mut dyn Simulation,
    damping: Option<&[f64]>,
    ctrl: &[f64],
    substeps: usize,
) -> Result<(), String> {
    simulation.array_mut(Array::Ctrl).copy_from_slice(ctrl);
    match damping {
        None => simulation.call(Call::Step, substeps)?,
        Some(damping) => (0..substeps).try_for_each(|_| {
            damp(simulation, damping);
            simulation.call(Call::Step, 1)
        })?,
    }
    complaint(simulation).map_or(Ok(()), Err)
}

/// Applies damping at the velocity of this moment.
fn damp(simulation: &mut dyn Simulation, damping: &[f64]) {
    for (freedom, damping) in damping.iter().enumerate() {
        let velocity = simulation.array(Array::Qvel)[freedom];
        simulation.array_mut(Array::Applied)[freedom] = -damping * velocity;
    }
}

/// What is wrong with a simulation. MuJoCo resets states that it calls bad, and goes on; the
/// warning is what it leaves.
fn complaint(simulation: &dyn Simulation) -> Option<String> {
    let state = simulation.array(Array::Qpos).iter().chain(simulation.array(Array::Qvel));
    let finite = state.copied().all(f64::is_finite);
    simulation.warning().or_else(|| (!finite).then(|| "the state stopped being finite".into()))
}
