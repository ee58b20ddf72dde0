//! Cameras and their poses.
