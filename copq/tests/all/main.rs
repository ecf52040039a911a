//! All tests of the core, in one program.

mod allocations;
mod backend;
mod bounds;
mod check_env;
mod coverage;
mod exploration;
mod learner;
mod methods;
mod normaliser;
mod on_policy;
mod presets;
mod projection_degenerate;
mod projection_fixtures;
mod projection_golden;
mod projection_gradients;
mod projection_mean_std;
mod projection_oracle;
mod projection_properties;
mod replay;
mod td3;
mod toy;
