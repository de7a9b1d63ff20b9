//! Where viewers come in: opened before anything else starts, so that an address that cannot be had is said at once; served once the loop runs.

use std::io::Write;
use std::sync::mpsc::{self, Receiver};
use std::thread::{Scope, ScopedJoinHandle};

use haptor_engine::Scene;
use haptor_wire::{Summary, WorkBudget};

use super::figures::SharedFigures;
use super::listen::{Listener, ViewerAddress};
use super::server::{Parts, Server};
use super::token::{TOKEN_VARIABLE, Token};
use super::workshop::Workshop;
use crate::config::Config;
use crate::error::HostError;
use crate::recorder::orders::Orders;
use crate::recorder::origin::Origin;
use crate::rt::desk::{Counter, Desk, closed_desk, desk};
use crate::session::start;

/// An open entrance and what those who come must know.
#[derive(Debug)]
pub struct Entrance {
    listener: Listener,
    token: Option<Token>,
    counter: Counter,
}

/// What the server needs of a session.
#[derive(Debug)]
pub struct Session {
    /// The scene that runs first.
    pub scene: Scene,
    /// What says how much a tick of it, and of those after it, may spend.
    pub budget: WorkBudget,
    /// Its file.
    pub origin: Origin,
    /// Of the recorder.
    pub recorder: Orders,
    /// That the recorder writes.
    pub figures: SharedFigures,
    /// The session's end.
    pub end: Receiver<Summary>,
}

impl Entrance {
    /// Opens what the configuration asks for, and makes the loop's desk to go with it.
    ///
    /// # Errors
    /// [`HostError::Listen`] when the address cannot be had, [`HostError::File`] or [`HostError::Argument`] when the token cannot be read.
    pub fn open(config: &Config) -> Result<(Option<Self>, Desk), HostError> {
        let Some(address) = &config.viewer else { return Ok((None, closed_desk())) };
        let token = token(config, address)?;
        let listener = Listener::open(address)?;
        let told = listener.address().unwrap_or_else(|_| address.clone());
        say(format_args!("viewers come in at {told}"));
        let (desk, counter) = desk();
        Ok((Some(Self { listener, token, counter }), desk))
    }

    /// Starts the threads that serve viewers; yields the one that ends with the session.
    ///
    /// # Errors
    /// [`HostError::Thread`] when one cannot be started.
    pub fn serve<'scope>(
        self,
        scope: &'scope Scope<'scope, '_>,
        session: Session,
    ) -> Result<ScopedJoinHandle<'scope, ()>, HostError> {
        let ((jobs, to_do), (send_made, made)) = (mpsc::channel(), mpsc::channel());
        let rate_hz = session.origin.header.rate_hz;
        let workshop = Workshop::new(session.scene, session.budget, rate_hz, send_made);
        start(scope, "viewer-work", move || workshop.run(&to_do))?;
        let server = Server::new(Parts {
            listener: self.listener,
            token: self.token,
            rate_hz,
            digest: session.origin.header.scene_digest,
            file: session.origin.scene().clone(),
            counter: self.counter,
            recorder: session.recorder,
            figures: session.figures,
            jobs,
            made,
        });
        start(scope, "viewers", move || server.run(&session.end))
    }
}

/// The token: of the file, of the environment, or, where others than this machine's programs may come, a new one that is told once.
fn token(config: &Config, address: &ViewerAddress) -> Result<Option<Token>, HostError> {
    let given = match &config.token_file {
        Some(path) => Some(Token::read(path)?),
        None => Token::of_environment(std::env::var(TOKEN_VARIABLE).ok().as_deref())?,
    };
    if given.is_some() || address.is_local() {
        return Ok(given);
    }
    let made = Token::generate()?;
    say(format_args!("viewers from elsewhere need this token: {TOKEN_VARIABLE}={}", made.to_hex()));
    Ok(Some(made))
}

/// Tells whoever is left to hear it.
fn say(what: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr(), "haptor-host: {what}");
}
