//! Who may come in: on this machine whoever reaches the socket, from elsewhere whoever knows the token.
//!
//! A token is 32 bytes, written as 64 hexadecimal digits: in a file, or in the environment. It crosses the network as it is, like all the
//! link says: on a network that others can listen to, tunnel the link (e.g. `ssh -L`) instead of opening it.

use std::fmt::{self, Write as _};
use std::fs::File;
use std::hint::black_box;
use std::io::Read;
use std::path::Path;

use haptor_wire::viewer::{NO_TOKEN, TOKEN_BYTES, token_from_hex};

use crate::error::HostError;

/// The variable of the environment that holds a token.
pub const TOKEN_VARIABLE: &str = "HAPTOR_TOKEN";

/// Where the system hands out randomness.
const RANDOMNESS: &str = "/dev/urandom";

/// What lets a viewer in. Never all zeros.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Token([u8; TOKEN_BYTES]);

impl fmt::Debug for Token {
    /// Without the token: what is debugged ends up in logs.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token")
    }
}

impl Token {
    /// Reads 64 hexadecimal digits; white space around them does not matter.
    #[must_use]
    pub fn from_hex(text: &str) -> Option<Self> {
        token_from_hex(text).map(Self)
    }

    /// As 64 hexadecimal digits.
    #[must_use]
    pub fn to_hex(self) -> String {
        self.0.iter().fold(String::new(), |mut text, byte| {
            // writing to a string cannot fail
            let _ = write!(text, "{byte:02x}");
            text
        })
    }

    /// A new one, from the system's randomness.
    ///
    /// # Errors
    /// [`HostError::File`] when the system has none.
    pub fn generate() -> Result<Self, HostError> {
        let mut token = NO_TOKEN;
        let read = File::open(RANDOMNESS).and_then(|mut source| source.read_exact(&mut token));
        let failed = |reason| HostError::File { doing: "make a token from", path: RANDOMNESS.into(), reason };
        read.map_err(failed)?;
        Ok(Self(token))
    }

    /// The token of a file.
    ///
    /// # Errors
    /// [`HostError::File`] when the file cannot be read, [`HostError::Argument`] when it holds no token.
    pub fn read(path: &Path) -> Result<Self, HostError> {
        let read = std::fs::read_to_string(path);
        let text = read.map_err(|reason| HostError::File { doing: "read the token", path: path.to_owned(), reason })?;
        Self::from_hex(&text).ok_or_else(|| refused("--token-file", path.display().to_string()))
    }

    /// The token of the environment, if it holds one.
    ///
    /// # Errors
    /// [`HostError::Argument`] when what it holds is none.
    pub fn of_environment(value: Option<&str>) -> Result<Option<Self>, HostError> {
        // a secret does not go into a message
        value.map(|text| Self::from_hex(text).ok_or_else(|| refused(TOKEN_VARIABLE, "something else".to_owned()))).transpose()
    }

    /// Whether it is this one, in a time that does not depend on where they differ.
    #[must_use]
    pub fn is(&self, said: &[u8; TOKEN_BYTES]) -> bool {
        self.0.iter().zip(said).fold(0, |differs, (a, b)| black_box(differs | (a ^ b))) == 0
    }
}

fn refused(name: &'static str, value: String) -> HostError {
    HostError::Argument { name, value, allowed: "64 hexadecimal digits, not all 0 (e.g. from `openssl rand -hex 32`)" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_read_as_they_print_and_differ_anywhere() {
        let token = Token::generate().unwrap();
        assert_ne!(token, Token::generate().unwrap());
        assert_eq!(Token::from_hex(&format!(" {}\n", token.to_hex())), Some(token));
        assert!(token.is(&token.0));
        for at in 0..TOKEN_BYTES {
            let mut other = token.0;
            other[at] ^= 1;
            assert!(!token.is(&other));
        }
        assert_eq!(format!("{token:?}"), "Token");
    }

    #[test]
    fn what_is_no_token_is_refused_without_being_repeated() {
        let (short, zeros, odd) = ("ab".repeat(31), "0".repeat(64), "a".repeat(65));
        for text in ["", "xyz", &short, &zeros, &odd] {
            assert_eq!(Token::from_hex(text), None, "{text}");
        }
        let error = Token::of_environment(Some("secret")).unwrap_err().to_string();
        assert!(error.contains("HAPTOR_TOKEN") && error.contains("64 hexadecimal") && !error.contains("secret"), "{error}");
        assert!(Token::of_environment(None).unwrap().is_none());
    }
}
