//! Run folders, metrics, checkpoints and figures for copq's training runs.
