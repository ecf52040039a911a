//! How a training run ended.

use std::fmt;
use std::path::PathBuf;

use crate::numbers::grouped;

/// How [`Run::train`](crate::Run::train) ended; prints as a sentence for the user.
///
/// ```
/// use copq_experiments::Ending;
///
/// let ending = Ending::Interrupted { step: 12_000, folder: "runs/first".into() };
/// let words = "stopped and saved at step 12,000; go on with copq resume runs/first";
/// assert_eq!(ending.to_string(), words);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ending {
    /// All steps are done.
    Finished {
        /// The run's folder.
        folder: PathBuf,
    },
    /// A signal came; the checkpoint is of this moment.
    Interrupted {
        /// Environment steps done.
        step: u64,
        /// The run's folder.
        folder: PathBuf,
    },
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finished { folder } => {
                write!(f, "finished; everything is in {}", folder.display())
            }
            Self::Interrupted { step, folder } => {
                write!(
                    f,
                    "stopped and saved at step {}; go on with copq resume {}",
                    grouped(*step),
                    folder.display()
                )
            }
        }
    }
}
