//! The viewer link from the viewer's side: connect to a running host, look, ask, upload, and come back when the connection was lost.
//!
//! ```text
//! Viewer (comes back) ──► Connection ──► socket ◄──► host      core/wire/VIEWER.md
//!                             ▲ a thread reads and pings
//! ```
//! | file | what it is |
//! |---|---|
//! | [`address`] | where a host is, and the token that lets one in |
//! | [`connection`] | a connection that has been let in: messages, requests |
//! | [`transfer`] | models up, scenes and recordings down, rest points |
//! | [`viewer`] | a connection that is made anew when it is lost |
//! | [`error`] | what can go wrong |

pub mod address;
pub mod connection;
pub mod error;
pub mod transfer;
pub mod viewer;

pub use address::{Address, Token};
pub use connection::Connection;
pub use error::ClientError;
pub use viewer::{News, Viewer};
