//! The problem library: each problem with its published or analytic answer and
//! the source of that answer.
#![allow(dead_code, unreachable_pub)]

pub mod control;
pub mod five_link;
pub mod hock_schittkowski;
pub mod special;
