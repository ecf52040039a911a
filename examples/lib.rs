//! Training programs that show copq at work, one file each.
