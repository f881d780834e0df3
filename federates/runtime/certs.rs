//! Certificates of a federation as files of one folder: `authority.pem`, and `NAME.pem` with `NAME.key` for each
//! federate. `seeds certs` makes them.

use std::path::{Path, PathBuf};

/// Name of the authority's certificate.
pub const AUTHORITY: &str = "authority.pem";

/// The files that one federate needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Certs {
    /// Certificate of the authority that signed all others.
    pub authority: PathBuf,
    /// Own certificate.
    pub certificate: PathBuf,
    /// Its key.
    pub key: PathBuf,
}

impl Certs {
    /// What a plane is told of them (`transport/link/tls`): both ends show theirs, and the name must be the other's.
    #[must_use]
    pub fn of_links(&self) -> serde_json::Value {
        let Self { authority, certificate, key } = self;
        serde_json::json!({
            "root_ca_certificate": authority,
            "enable_mtls": true,
            "verify_name_on_connect": true,
            "close_link_on_expiration": true,
            "listen_certificate": certificate,
            "listen_private_key": key,
            "connect_certificate": certificate,
            "connect_private_key": key,
        })
    }

    /// The files of federate `name` in `folder`.
    ///
    /// # Errors
    /// If one of them is not there: which, and what to do.
    pub fn of(folder: &Path, name: &str) -> Result<Self, String> {
        let certs = Self {
            authority: folder.join(AUTHORITY),
            certificate: folder.join(format!("{name}.pem")),
            key: folder.join(format!("{name}.key")),
        };
        for file in [&certs.authority, &certs.certificate, &certs.key] {
            if let Err(e) = std::fs::File::open(file) {
                return Err(format!(
                    "--certs: {}: {e}: `seeds certs {}` makes certificates for all federates (--generators N for several traffic generators)",
                    file.display(),
                    folder.display()
                ));
            }
        }
        Ok(certs)
    }
}

/// Checks an endpoint against what protects it.
///
/// # Errors
/// If it is `tls/…` without certificates or the other way round; or if it can be reached from other hosts, nothing
/// protects it, and `open` does not say that this is meant.
pub fn allowed(endpoint: &str, certs: bool, open: bool) -> Result<(), String> {
    let (transport, place) = endpoint.split_once('/').unwrap_or(("", endpoint));
    match (transport == "tls", certs) {
        (true, false) => Err(format!(
            "{endpoint} needs certificates: --certs DIR (`seeds certs DIR` makes them)"
        )),
        (false, true) => Err(format!("with --certs the endpoint is tls/{place}, not {endpoint}")),
        (true, true) => Ok(()),
        (false, false) if open || is_loopback(endpoint) => Ok(()),
        (false, false) => Err(format!(
            "everybody who reaches {place} could command this run: protect it with --certs DIR and tls/{place} (`seeds certs DIR` makes certificates), or say --open"
        )),
    }
}

/// Whether only this host reaches `endpoint`.
#[must_use]
pub fn is_loopback(endpoint: &str) -> bool {
    let place = endpoint.split_once('/').map_or(endpoint, |(_, place)| place);
    let host = place.rsplit_once(':').map_or(place, |(host, _)| host).trim_matches(['[', ']']);
    host.eq_ignore_ascii_case("localhost")
        || host.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_listens_beyond_this_host_without_certificates_or_a_word() {
        for (endpoint, certs, open, words) in [
            ("tcp/127.0.0.1:7447", false, false, None),
            ("tcp/[::1]:7447", false, false, None),
            ("tcp/localhost:0", false, false, None),
            ("tcp/10.0.0.1:7447", false, true, None),
            ("tls/10.0.0.1:7447", true, false, None),
            ("tcp/0.0.0.0:0", false, false, Some("could command this run")),
            ("tcp/[::]:7447", false, false, Some("--open")),
            ("tcp/host.example:7447", false, false, Some("--certs DIR")),
            ("tls/127.0.0.1:7447", false, true, Some("needs certificates")),
            ("tcp/127.0.0.1:7447", true, true, Some("tls/127.0.0.1:7447, not")),
        ] {
            let said = allowed(endpoint, certs, open).err();
            match (words, said) {
                (None, None) => {}
                (Some(words), Some(said)) if said.contains(words) => {}
                (_, said) => panic!("{endpoint} certs {certs} open {open}: {said:?}"),
            }
        }
    }

    #[test]
    fn a_missing_certificate_is_named_with_what_makes_it() {
        let said = Certs::of(Path::new("/nowhere"), "smdfm").expect_err("there is none");
        assert!(said.contains("/nowhere/authority.pem") && said.contains("seeds certs /nowhere"));
    }
}
