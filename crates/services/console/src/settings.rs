//! The settings.

use std::collections::BTreeSet;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::{self, Secret, settings};
use ppnpack_wire::keys::Cell;

const DEFAULT_PORT: u16 = 8770;

/// Minimum and maximum length of a token: a shorter one can be guessed.
const TOKEN_LENGTH: std::ops::RangeInclusive<usize> = 16..=256;

/// Minimum of different characters of a token: 16 random hexadecimal digits have fewer in one of
/// 30,000 cases.
const TOKEN_VARIETY: usize = 6;

/// The reason why controls are off where no token is set.
pub(crate) const NO_TOKEN: &str = "no token is configured: set service.token_file (of `ppnpack up`, the variable PPNPACK_CONSOLE_TOKEN)";

settings! {
    /// Settings of the operator's page.
    pub struct Settings {
        /// The address that the page is served at; for port 0 the system chooses one. Whoever
        /// reaches it sees the cells.
        pub listen: SocketAddr = SocketAddr::from((Ipv4Addr::LOCALHOST, DEFAULT_PORT)),
        /// The cells that are shown, and the containers of a cell that has several; where none is
        /// named, all.
        pub cells: Vec<String> = Vec::new(),
        /// Names under which browsers may ask for the page, beside addresses and `localhost`.
        pub hosts: Vec<String> = Vec::new(),
        /// The token that controls ask for; without it, or a file with it, there are none.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub token: Option<Secret> = None,
        /// A file with the token, in place of the token itself.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub token_file: Option<PathBuf> = None,
    }
}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        if self.token.is_some() && self.token_file.is_some() {
            return Err("token, token_file: give one of them".to_owned());
        }
        self.cell_names()?;
        let is_name = |host: &String| {
            !host.is_empty()
                && host
                    .bytes()
                    .all(|byte| byte.is_ascii_alphanumeric() || b".-".contains(&byte))
        };
        if let Some(host) = self.hosts.iter().find(|host| !is_name(host)) {
            return Err(format!(
                "hosts: '{host}' is no name such as cell.example, without a port"
            ));
        }
        self.token.as_ref().map_or(Ok(()), check)
    }
}

impl Settings {
    /// Gives the cells and containers that are shown; none where all are.
    pub(crate) fn cell_names(&self) -> Result<Vec<Cell>, String> {
        configuration::cells(&self.cells)
    }

    /// Gives the token that controls ask for, where there is one.
    ///
    /// # Errors
    /// The file that cannot be read, or what is wrong with the token.
    pub(crate) fn read_token(&self) -> Result<Option<Secret>, String> {
        let Some(path) = &self.token_file else {
            return Ok(self.token.clone());
        };
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("token_file: {} cannot be read: {error}", path.display()))?;
        let token = Secret::from(text.trim_end().to_owned());
        check(&token)?;
        Ok(Some(token))
    }
}

fn check(token: &Secret) -> Result<(), String> {
    let text = token.reveal();
    let variety = text.bytes().collect::<BTreeSet<u8>>().len();
    if TOKEN_LENGTH.contains(&text.len())
        && variety >= TOKEN_VARIETY
        && text.bytes().all(|byte| byte.is_ascii_graphic())
    {
        return Ok(());
    }
    let (least, most) = TOKEN_LENGTH.into_inner();
    Err(format!(
        "token: {least} to {most} visible ASCII characters without blanks are needed, {TOKEN_VARIETY} of them different, such as \
         `openssl rand -hex 32` prints (of `ppnpack up`, in the variable PPNPACK_CONSOLE_TOKEN)"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOKEN_LIKE: &str = "0123456789abcdef";

    fn with_token(text: &str) -> Settings {
        Settings {
            token: Some(Secret::from(text.to_owned())),
            ..Settings::default()
        }
    }

    #[test]
    fn controls_are_off_and_the_page_is_this_machines_by_default() {
        let settings = Settings::default();
        assert_eq!(settings.validate(), Ok(()));
        assert!(settings.listen.ip().is_loopback());
        assert_eq!(settings.read_token(), Ok(None));
    }

    #[test]
    fn a_token_has_to_be_hard_to_guess_and_to_fit_into_a_header() {
        assert_eq!(with_token(TOKEN_LIKE).validate(), Ok(()));
        let (repeated, long) = ("ab".repeat(16), TOKEN_LIKE.repeat(17));
        for text in ["", "short", "with a blank in it", &repeated, &long] {
            let refusal = with_token(text).validate().unwrap_err();
            assert!(refusal.starts_with("token: "), "{refusal}");
            assert!(text.is_empty() || !refusal.contains(text), "{refusal}");
        }
    }

    #[test]
    fn a_token_is_read_from_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("token");
        std::fs::write(&path, "0123456789abcdef\n").unwrap();
        let settings = Settings {
            token_file: Some(path.clone()),
            ..Settings::default()
        };
        let token = settings.read_token().unwrap().unwrap();
        assert_eq!(token.reveal(), "0123456789abcdef");
        std::fs::write(&path, "short").unwrap();
        assert!(settings.read_token().is_err());
        std::fs::remove_file(&path).unwrap();
        assert!(settings.read_token().unwrap_err().contains("token_file"));
    }

    #[test]
    fn hosts_are_names() {
        for (host, is_possible) in [("cell.example", true), ("cell:80", false), ("", false)] {
            let settings = Settings {
                hosts: vec![host.to_owned()],
                ..Settings::default()
            };
            assert_eq!(settings.validate().is_ok(), is_possible, "{host}");
        }
    }
}
