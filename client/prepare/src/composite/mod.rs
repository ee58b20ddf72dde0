//! Views of a part blended into pictures.

mod blend;
mod pyramid;
mod sprite;

pub use blend::{Method, Place, composite};
pub use sprite::Sprite;
