//! What the two ways to call MuJoCo have in common.

/// A model with its data, as C MuJoCo holds them.
pub(crate) trait Simulation: Send {
    /// One of the data's arrays.
    fn array(&self, array: Array) -> &[f64];

    /// One of the data's arrays, to write.
    fn array_mut(&mut self, array: Array) -> &mut [f64];

    /// Calls MuJoCo `times` times. An error is MuJoCo's own message; the data must then be reset.
    fn call(&mut self, call: Call, times: usize) -> Result<(), String>;

    /// The first of MuJoCo's warnings since the last reset of the data, in MuJoCo's words.
    fn warning(&self) -> Option<String>;

    /// The joint-space mass matrix of the last evaluation (nv x nv, row-major).
    fn mass_matrix(&self) -> Vec<f64>;

    /// New data for the same model.
    fn fork(&self) -> Result<Box<dyn Simulation>, String>;
}

/// Functions of the model and its data.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Call {
    /// mj_resetData
    Reset,
    /// mj_forward
    Forward,
    /// mj_step
    Step,
    /// mj_rnePostConstraint
    ContactForce,
}

/// Arrays of mjData, under MuJoCo's names. Arrays with a row for each body start with the world's
/// row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub(crate) enum Array {
    Time,
    Qpos,
    Qvel,
    Warmstart,
    Ctrl,
    Applied,
    Xpos,
    Xipos,
    Cinert,
    Cvel,
    QfrcActuator,
    CfrcExt,
}

impl Array {
    /// All that a simulation needs to continue bit for bit, and the fields that may be read before
    /// it does, with the names they are saved under. Controls and applied forces are written before
    /// every step.
    pub(crate) const SAVED: [(Self, &str); 10] = [
        (Self::Time, "time"),
        (Self::Qpos, "qpos"),
        (Self::Qvel, "qvel"),
        (Self::Warmstart, "qacc_warmstart"),
        (Self::Xpos, "xpos"),
        (Self::Xipos, "xipos"),
        (Self::Cinert, "cinert"),
        (Self::Cvel, "cvel"),
        (Self::QfrcActuator, "qfrc_actuator"),
        (Self::CfrcExt, "cfrc_ext"),
    ];
}
