//! The viewer: its panels and deeds driven without a window, drawn on a real adapter, and the window itself under a virtual
//! screen. Software adapters will do: on Debian `apt-get install mesa-vulkan-drivers xvfb xdotool imagemagick`, then
//! `cargo test --test viewer -- --include-ignored`.
#![cfg(feature = "viewer")]

mod common;
mod golden;
mod looks;
mod panels;
mod steer;
mod synth;
mod walk;
mod window;
