//! `seeds certs`: an authority and a certificate for each federate, and what is wrong with those that are there.

mod live;

use crate::federation::MOST_SMDFMS;
use crate::runtime::access_list;
use crate::runtime::certs::{AUTHORITY, is_loopback};
use crate::runtime::cli::{self, BAD_INPUT, COMPLETE, FAILED, fail, out};
use crate::runtime::clock::utc_ns;
use anyhow::Context;
use clap::{Args, Subcommand};
use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa,
    Issuer, KeyPair, KeyUsagePurpose,
};
use rustls_pki_types::CertificateDer;
use rustls_pki_types::pem::PemObject;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;
use time::OffsetDateTime;
use x509_parser::prelude::{FromDer, GeneralName, X509Certificate};

/// Make the certificates that protect the synchronisation plane between hosts, or check those that are there
#[derive(Args, Clone, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct CertsArgs {
    #[command(subcommand)]
    check: Option<Check>,

    #[command(flatten)]
    make: MakeArgs,
}

#[derive(Subcommand, Clone, Debug)]
enum Check {
    /// Say what is wrong with the certificates in a folder
    Check {
        /// Folder
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Endpoint that the certificates must be good for, like tls/10.0.0.1:7447; may be given several times
        #[arg(long, value_name = "ENDPOINT", value_parser = cli::endpoint)]
        endpoint: Vec<String>,
        /// Endpoint of a running federation: try there what each certificate is for; nothing of it has an effect on the run
        #[arg(long, value_name = "ENDPOINT", value_parser = cli::endpoint)]
        live: Option<String>,
        /// DIS exercise identifier of that federation, 0 to 255
        #[arg(long, value_name = "N", default_value_t = 1, requires = "live")]
        exercise: u8,
    },
}

#[derive(Args, Clone, Debug)]
struct MakeArgs {
    /// Folder for authority.pem and each federate's NAME.pem and NAME.key; copy to a host what its federates need
    #[arg(value_name = "DIR", required = true)]
    folder: Option<PathBuf>,

    /// Name or address of a host of the federation; may be given several times. This host's own are always in
    #[arg(long, value_name = "NAME|IP")]
    host: Vec<String>,

    /// Traffic generators, 1 to 16
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=16))]
    generators: u32,

    /// SMDFMs that share the sensors, 1 to 8
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SMDFMS)))]
    smdfms: u32,

    /// Days that the federates' certificates are valid, 1 to 3650
    #[arg(long, value_name = "N", default_value_t = 825, value_parser = clap::value_parser!(u32).range(1..=3650))]
    days: u32,

    /// Keep the authority's key (authority.key), so that the same authority can sign again later
    #[arg(long)]
    keep_authority: bool,
}

/// Makes or checks.
#[must_use]
pub fn run(args: &CertsArgs) -> ExitCode {
    match (&args.check, &args.make.folder) {
        (Some(Check::Check { folder, endpoint, live, exercise }), _) => {
            let live = live.as_deref().map(|endpoint| (endpoint, *exercise));
            check_all(folder, endpoint, live)
        }
        (None, Some(folder)) => match make(&args.make, folder) {
            Ok(()) => ExitCode::from(COMPLETE),
            Err(e) => fail(FAILED, format!("{e:#}")),
        },
        (None, None) => fail(BAD_INPUT, "certs: name a folder"),
    }
}

/// Days that an authority is valid: ten years.
const AUTHORITY_DAYS: u32 = 3650;
const DAY_S: i64 = 86_400;
const AUTHORITY_KEY: &str = "authority.key";

fn make(args: &MakeArgs, folder: &Path) -> anyhow::Result<()> {
    let mut hosts = vec!["127.0.0.1".to_owned(), "::1".to_owned(), "localhost".to_owned()];
    let own = crate::runtime::process::host_name();
    for host in args.host.iter().chain([&own]) {
        if !hosts.contains(host) && !host.contains(' ') {
            hosts.push(host.clone());
        }
    }
    let names = access_list::names(args.generators, args.smdfms);
    // All of it is looked at before the first file is there.
    let mut wanted = Vec::new();
    for name in &names {
        let mut alternatives = vec![name.clone()];
        alternatives.extend(hosts.iter().cloned());
        let mut params = CertificateParams::new(alternatives)
            .with_context(|| format!("--host: {}", args.host.join(", ")))?;
        params.distinguished_name = common_name(name);
        params.use_authority_key_identifier_extension = true;
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages =
            vec![ExtendedKeyUsagePurpose::ServerAuth, ExtendedKeyUsagePurpose::ClientAuth];
        (params.not_before, params.not_after) = validity(args.days);
        wanted.push((name, params));
    }
    std::fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
    let kept_before = folder.join(AUTHORITY_KEY).exists();
    let issuer = authority(folder)?;
    for (name, params) in wanted {
        let key = KeyPair::generate()?;
        let certificate = params.signed_by(&key, &issuer)?;
        cli::save(&folder.join(format!("{name}.pem")), certificate.pem())?;
        secret(&folder.join(format!("{name}.key")), &key.serialize_pem())?;
    }
    let count = names.len();
    out!("{count} certificates in {}, for {}", folder.display(), hosts.join(", "));
    if kept_before && !args.keep_authority {
        out!("the authority's key stays: it was kept before (remove {AUTHORITY_KEY} to end that)");
    } else if !args.keep_authority {
        let key = folder.join(AUTHORITY_KEY);
        std::fs::remove_file(&key).with_context(|| format!("removing {}", key.display()))?;
        out!(
            "the authority's key is not kept: nobody can sign another certificate for this federation (--keep-authority keeps it)"
        );
    }
    Ok(())
}

/// The authority in `folder`, made if there is none. Its key is in the folder afterwards.
fn authority(folder: &Path) -> anyhow::Result<Issuer<'static, KeyPair>> {
    let (certificate, key) = (folder.join(AUTHORITY), folder.join(AUTHORITY_KEY));
    if certificate.exists() {
        anyhow::ensure!(
            key.exists(),
            "{} is there and its key is not: this authority can sign nothing more; choose an empty folder",
            certificate.display()
        );
        let name = Seen::read(&certificate)?.name;
        let text = std::fs::read_to_string(&key).with_context(|| key.display().to_string())?;
        let pair = KeyPair::from_pem(&text).with_context(|| key.display().to_string())?;
        return Ok(Issuer::new(authority_params(&name), pair));
    }
    let mut tag = [0; 6];
    getrandom::fill(&mut tag).context("drawing the authority's name")?;
    let tag: String = tag.iter().map(|octet| format!("{octet:02x}")).collect();
    let params = authority_params(&format!("SEEDS authority {tag}"));
    let pair = KeyPair::generate()?;
    let signed = params.self_signed(&pair)?;
    secret(&key, &pair.serialize_pem())?;
    cli::save(&certificate, signed.pem())?;
    Ok(Issuer::new(params, pair))
}

fn authority_params(name: &str) -> CertificateParams {
    let mut params = CertificateParams::default();
    params.distinguished_name = common_name(name);
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    (params.not_before, params.not_after) = validity(AUTHORITY_DAYS);
    params
}

fn common_name(name: &str) -> DistinguishedName {
    let mut distinguished = DistinguishedName::new();
    distinguished.push(DnType::CommonName, name);
    distinguished
}

/// From yesterday, for clocks that differ, to `days` from now.
fn validity(days: u32) -> (OffsetDateTime, OffsetDateTime) {
    let at = |days: i64| {
        let seconds = utc_ns() / 1_000_000_000 + days * DAY_S;
        OffsetDateTime::from_unix_timestamp(seconds).unwrap_or(OffsetDateTime::UNIX_EPOCH)
    };
    (at(-1), at(i64::from(days)))
}

/// Writes a file that only its owner may read.
fn secret(file: &Path, text: &str) -> anyhow::Result<()> {
    use std::io::Write;
    use std::os::unix::fs::OpenOptionsExt;
    let doing = || format!("writing {}", file.display());
    match std::fs::remove_file(file) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(e).with_context(doing),
        _ => {}
    }
    let mut options = std::fs::OpenOptions::new();
    let mut open =
        options.write(true).create_new(true).mode(0o600).open(file).with_context(doing)?;
    open.write_all(text.as_bytes()).with_context(doing)
}

/// What a certificate says.
struct Seen {
    der: CertificateDer<'static>,
    name: String,
    hosts: Vec<String>,
    not_after_s: i64,
    public_key: Vec<u8>,
}

impl Seen {
    fn read(file: &Path) -> anyhow::Result<Self> {
        let octets = std::fs::read(file).with_context(|| file.display().to_string())?;
        let der = CertificateDer::from_pem_slice(&octets)
            .map_err(|e| anyhow::anyhow!("{}: not a certificate in PEM: {e}", file.display()))?;
        let (_, x509) = X509Certificate::from_der(&der)
            .map_err(|e| anyhow::anyhow!("{}: not a certificate: {e}", file.display()))?;
        let name = x509
            .subject()
            .iter_common_name()
            .next()
            .and_then(|name| name.as_str().ok())
            .unwrap_or_default()
            .to_owned();
        let alternatives = x509.subject_alternative_name().ok().flatten();
        let hosts = alternatives
            .iter()
            .flat_map(|found| &found.value.general_names)
            .filter_map(|name| match name {
                GeneralName::DNSName(name) => Some((*name).to_owned()),
                GeneralName::IPAddress(octets) => address(octets),
                _ => None,
            })
            .collect();
        let not_after_s = x509.validity().not_after.timestamp();
        let public_key = x509.public_key().subject_public_key.data.to_vec();
        Ok(Self { name, hosts, not_after_s, public_key, der: der.clone() })
    }

    /// What is wrong with it as the certificate of federate `name`.
    fn faults(&self, name: &str, authority: &Self, endpoints: &[String]) -> Vec<String> {
        let mut faults = Vec::new();
        if self.name != name {
            faults.push(format!("it is the certificate of '{}'", self.name));
        }
        if !access_list::names(16, MOST_SMDFMS).contains(&self.name) {
            faults.push(format!("no federate is called '{}': it may do nothing", self.name));
        }
        let now = rustls_pki_types::UnixTime::since_unix_epoch(Duration::from_nanos(
            utc_ns().max(0) as u64,
        ));
        let verified = webpki::anchor_from_trusted_cert(&authority.der).and_then(|anchor| {
            let own = webpki::EndEntityCert::try_from(&self.der)?;
            for usage in [webpki::KeyUsage::server_auth(), webpki::KeyUsage::client_auth()] {
                own.verify_for_usage(
                    webpki::ALL_VERIFICATION_ALGS,
                    std::slice::from_ref(&anchor),
                    &[],
                    now,
                    usage,
                    None,
                    None,
                )?;
            }
            Ok(())
        });
        if let Err(e) = verified {
            faults.push(format!("the authority does not vouch for it: {e:?}"));
        }
        for endpoint in endpoints {
            let place = endpoint.split_once('/').map_or(&endpoint[..], |(_, place)| place);
            let host = place.rsplit_once(':').map_or(place, |(host, _)| host);
            let host = host.trim_matches(['[', ']']);
            let any = ["0.0.0.0", "::"].contains(&host);
            if !any && !self.hosts.iter().any(|named| same_host(named, host)) {
                faults.push(format!("it is not for {host}: make it again with --host {host}"));
            }
        }
        faults
    }
}

/// Whether two texts name the same host: addresses by what they are, names in any case.
fn same_host(a: &str, b: &str) -> bool {
    match (a.parse::<std::net::IpAddr>(), b.parse::<std::net::IpAddr>()) {
        (Ok(a), Ok(b)) => a.to_canonical() == b.to_canonical(),
        (Err(_), Err(_)) => a.eq_ignore_ascii_case(b),
        _ => false,
    }
}

fn address(octets: &[u8]) -> Option<String> {
    let v4 = <[u8; 4]>::try_from(octets).map(std::net::IpAddr::from);
    let v6 = <[u8; 16]>::try_from(octets).map(std::net::IpAddr::from);
    Some(v4.or(v6).ok()?.to_string())
}

/// Days before its end from which on a certificate is told of.
const SOON_DAYS: i64 = 30;

fn check_all(folder: &Path, endpoints: &[String], live: Option<(&str, u8)>) -> ExitCode {
    let both = checked(folder, endpoints).and_then(|faults| {
        let Some((endpoint, exercise)) = live else { return Ok(faults) };
        anyhow::ensure!(
            endpoint.starts_with("tls/"),
            "--live {endpoint}: a federation with certificates listens at tls/ADDRESS:PORT"
        );
        let mut more = 0;
        for (name, faults) in live::check(folder, &names_in(folder)?, endpoint, exercise) {
            let good = "connects, hears and is answered as it should be".to_owned();
            let verdict = if faults.is_empty() { good } else { faults.join("; ") };
            out!("{name:<24}at {endpoint}  {verdict}");
            more += faults.len();
        }
        Ok(faults + more)
    });
    match both {
        Ok(0) => ExitCode::from(COMPLETE),
        Ok(1) => fail(FAILED, format!("1 fault in {}", folder.display())),
        Ok(faults) => fail(FAILED, format!("{faults} faults in {}", folder.display())),
        Err(e) => fail(BAD_INPUT, format!("{e:#}")),
    }
}

/// Names of the certificates in a folder, sorted, without the authority.
fn names_in(folder: &Path) -> anyhow::Result<Vec<String>> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .with_context(|| folder.display().to_string())?
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.strip_suffix(".pem").map(str::to_owned))
        .filter(|name| format!("{name}.pem") != AUTHORITY)
        .collect();
    names.sort();
    Ok(names)
}

fn checked(folder: &Path, endpoints: &[String]) -> anyhow::Result<usize> {
    use std::os::unix::fs::PermissionsExt;
    let authority = Seen::read(&folder.join(AUTHORITY))?;
    let names = names_in(folder)?;
    anyhow::ensure!(!names.is_empty(), "{}: no certificate but the authority's", folder.display());
    for endpoint in endpoints.iter().filter(|e| !e.starts_with("tls/") && !is_loopback(e)) {
        out!("{endpoint}: certificates protect tls/ endpoints only");
    }
    let mut count = 0;
    for name in names {
        let seen = Seen::read(&folder.join(format!("{name}.pem")))?;
        let days = (seen.not_after_s - utc_ns() / 1_000_000_000) / DAY_S;
        let mut faults = seen.faults(&name, &authority, endpoints);
        let key = folder.join(format!("{name}.key"));
        match std::fs::read_to_string(&key).map(|text| KeyPair::from_pem(&text)) {
            Ok(Ok(pair)) if pair.public_key_raw() == seen.public_key => {}
            Ok(Ok(_)) => faults.push(format!("{} is the key of another one", key.display())),
            Ok(Err(e)) => faults.push(format!("{}: {e}", key.display())),
            Err(e) => faults.push(format!("{}: {e}", key.display())),
        }
        let mode = std::fs::metadata(&key).map_or(0, |m| m.permissions().mode() & 0o777);
        if mode & 0o077 != 0 {
            let key = key.display();
            faults.push(format!("others may read {key} (mode {mode:o}): chmod 600 {key}"));
        }
        if (0..SOON_DAYS).contains(&days) {
            faults.push(format!("it ends in {days} days"));
        }
        count += faults.len();
        let verdict = if faults.is_empty() { "good".to_owned() } else { faults.join("; ") };
        out!("{name:<24}{days:>6} days  {}  {verdict}", seen.hosts.join(" "));
    }
    Ok(count)
}

/// Makes certificates of all federates in `folder`, for tests.
///
/// # Errors
/// If they cannot be made.
#[cfg(test)]
pub(crate) fn make_in(folder: &Path) -> anyhow::Result<()> {
    let args = MakeArgs {
        folder: None,
        host: vec!["10.83.0.1".to_owned()],
        generators: 2,
        smdfms: 2,
        days: 90,
        keep_authority: true,
    };
    make(&args, folder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// A folder that goes with its value.
    struct Folder(PathBuf);

    impl Folder {
        fn new() -> Self {
            static NEXT: AtomicU32 = AtomicU32::new(0);
            let number = NEXT.fetch_add(1, Ordering::Relaxed);
            let name = format!("seeds-certs-{}-{number}", std::process::id());
            Self(std::env::temp_dir().join(name))
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn what_is_made_is_good_and_each_fault_is_found() {
        let folder = Folder::new();
        let at = |name: &str| folder.0.join(name);
        make_in(&folder.0).expect("made");
        assert_eq!(checked(&folder.0, &[]).expect("checked"), 0, "nothing is wrong with them");
        let endpoint = |host: &str| vec![format!("tls/{host}:7447")];
        assert_eq!(checked(&folder.0, &endpoint("10.83.0.1")).expect("checked"), 0);
        let all = access_list::names(2, 2).len();
        assert_eq!(checked(&folder.0, &endpoint("10.83.0.9")).expect("checked"), all);
        let key = at("smdfm.key");
        let mode =
            |file: &Path| std::fs::metadata(file).expect("there").permissions().mode() & 0o777;
        assert_eq!((mode(&key), mode(&at(AUTHORITY_KEY))), (0o600, 0o600));
        // Others may read a key.
        std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o644)).expect("set");
        assert_eq!(checked(&folder.0, &[]).expect("checked"), 1);
        std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o600)).expect("set");
        // The key of another one.
        let own = std::fs::read(&key).expect("read");
        std::fs::copy(at("operator.key"), &key).expect("copied");
        assert_eq!(checked(&folder.0, &[]).expect("checked"), 1);
        std::fs::write(&key, own).expect("written");
        // A certificate under another name.
        let own = std::fs::read(at("smdfm.pem")).expect("read");
        std::fs::copy(at("operator.pem"), at("smdfm.pem")).expect("copied");
        assert_eq!(checked(&folder.0, &[]).expect("checked"), 2, "name and key");
        std::fs::write(at("smdfm.pem"), own).expect("written");
        assert_eq!(checked(&folder.0, &[]).expect("checked"), 0);
        // Another authority.
        let other = Folder::new();
        make_in(&other.0).expect("made");
        std::fs::copy(other.0.join(AUTHORITY), at(AUTHORITY)).expect("copied");
        assert_eq!(checked(&folder.0, &[]).expect("checked"), all);
    }

    #[test]
    fn the_same_authority_signs_again_where_its_key_was_kept() {
        let folder = Folder::new();
        make_in(&folder.0).expect("made");
        let before = std::fs::read(folder.0.join(AUTHORITY)).expect("read");
        let old = std::fs::read(folder.0.join("smdfm.pem")).expect("read");
        make_in(&folder.0).expect("made again");
        assert_eq!(std::fs::read(folder.0.join(AUTHORITY)).expect("read"), before);
        assert_ne!(std::fs::read(folder.0.join("smdfm.pem")).expect("read"), old);
        assert_eq!(checked(&folder.0, &[]).expect("checked"), 0);
        std::fs::remove_file(folder.0.join(AUTHORITY_KEY)).expect("removed");
        let refused = make_in(&folder.0).expect_err("no key").to_string();
        assert!(refused.contains("choose an empty folder"), "{refused}");
    }

    fn args(host: &str, keep_authority: bool) -> MakeArgs {
        let host = vec![host.to_owned()];
        MakeArgs { folder: None, host, generators: 1, smdfms: 1, days: 90, keep_authority }
    }

    #[test]
    fn a_host_that_cannot_be_named_leaves_nothing_behind() {
        let folder = Folder::new();
        make(&args("bür\u{fc}.example", true), &folder.0).expect_err("no name of a host");
        assert!(!folder.0.exists(), "nothing was made");
    }

    #[test]
    fn a_key_that_was_kept_stays_and_one_that_was_not_goes() {
        let folder = Folder::new();
        let key = || folder.0.join(AUTHORITY_KEY).exists();
        make(&args("10.83.0.1", true), &folder.0).expect("made");
        assert!(key());
        make(&args("10.83.0.2", false), &folder.0).expect("renewed");
        assert!(key(), "whoever kept it wants to sign again");
        let other = Folder::new();
        make(&args("10.83.0.1", false), &other.0).expect("made");
        assert!(!other.0.join(AUTHORITY_KEY).exists());
    }

    #[test]
    fn hosts_are_the_same_however_they_are_written() {
        let folder = Folder::new();
        make(&args("2001:db8::1", true), &folder.0).expect("made");
        for host in ["[2001:DB8:0:0::1]", "[2001:db8::1]", "LOCALHOST", "[::1]", "127.0.0.1"] {
            let endpoint = vec![format!("tls/{host}:7447")];
            assert_eq!(checked(&folder.0, &endpoint).expect("checked"), 0, "{host}");
        }
        for host in ["[2001:db8::2]", "localhos", "127.0.0.2"] {
            let endpoint = vec![format!("tls/{host}:7447")];
            assert!(checked(&folder.0, &endpoint).expect("checked") > 0, "{host}");
        }
    }
}
