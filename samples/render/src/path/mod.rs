//! `--path`: plays key-frames of camera and objects, a picture and a line of figures a frame.

mod crowd;
mod curve;
mod file;
mod play;
mod row;
mod stage;

pub use play::run;
pub use stage::Stage;
