//! Configurations from several sources.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use ppnpack_service::configuration::{
    AdminListen, Configuration, ConfigurationError, Endpoints, Mode, Secret, ServiceSettings,
    Sources, ZenohSettings,
};
use ppnpack_wire::keys::Service;
use ppnpack_wire::{MAX_CLOUD_BYTES, MAX_MESSAGE_BYTES};
use serde::{Deserialize, Serialize};

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Settings {
    threads: usize,
    share: f64,
    store: Store,
}

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Store {
    folder: String,
    #[serde(flatten)]
    retention: Retention,
}

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Retention {
    days: u32,
    backup: Backup,
}

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Backup {
    every_s: f64,
}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        if self.threads > 64 {
            return Err("threads: 0 to 64 is possible".to_owned());
        }
        Ok(())
    }
}

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct RouterSettings {}

impl ServiceSettings for RouterSettings {
    fn validate(&self) -> Result<(), String> {
        Ok(())
    }

    fn zenoh() -> ZenohSettings {
        ZenohSettings {
            mode: Mode::Router,
            listen: Endpoints(vec!["tcp/127.0.0.1:7447".to_owned()]),
            ..ZenohSettings::default()
        }
    }
}

fn load(
    file: Option<&str>,
    environment: &[(&str, &str)],
    assignments: &[&str],
) -> Result<Configuration<Settings>, ConfigurationError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.toml");
    std::fs::write(&path, file.unwrap_or_default()).unwrap();
    let owned = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
    let assignments: Vec<String> = assignments.iter().map(|&text| text.to_owned()).collect();
    let sources = Sources {
        file: file.map(|_| path.as_path()),
        environment: environment.iter().map(owned).collect(),
        assignments: &assignments,
    };
    Configuration::load(Service::Planner, &sources)
}

fn set(assignments: &[&str]) -> Configuration<Settings> {
    load(None, &[], assignments).unwrap()
}

fn load_router(assignments: &[String]) -> Result<ZenohSettings, ConfigurationError> {
    let sources = Sources {
        assignments,
        ..Sources::default()
    };
    let router = Configuration::<RouterSettings>::load(Service::Router, &sources);
    router.map(|router| router.zenoh)
}

#[test]
fn later_sources_are_stronger() {
    let file = "
        instance = 'from-file'
        shutdown_grace_s = 2
        [zenoh]
        mode = 'peer'
        listen = ['tcp/127.0.0.1:0']
        [service]
        threads = 1
        share = 0.5
        store.folder = '/a'
    ";
    let environment = [
        ("PPNPACK__SERVICE__THREADS", "2"),
        ("PPNPACK__INSTANCE", "from-environment"),
        ("PPNPACK__ZENOH__CONNECT", "tcp/a:1, tcp/b:2"),
        ("PATH", "/bin"),
        ("PPNPACK_OTHER", "1"),
    ];
    let assignments = ["service.threads = 3", "admin.listen=off", "service.share=1"];
    let configuration = load(Some(file), &environment, &assignments).unwrap();
    assert_eq!(configuration.instance, "from-environment");
    assert_eq!(configuration.shutdown_grace().as_secs(), 2);
    assert_eq!(configuration.admin.listen, AdminListen::Off);
    let service = configuration.service;
    assert_eq!((service.threads, service.share), (3, 1.0));
    assert_eq!(service.store.folder, "/a");
    let zenoh = configuration.zenoh;
    assert_eq!(zenoh.mode, Mode::Peer);
    let connect = ["tcp/a:1", "tcp/b:2"].map(str::to_owned);
    assert_eq!(zenoh.connect, Some(Endpoints(connect.to_vec())));
}

#[test]
fn a_service_is_a_client_on_this_machine_or_has_its_own_way_where_nothing_else_is_said() {
    let configuration = set(&[]);
    assert_eq!(configuration.instance, "planner-1");
    assert_eq!(configuration.zenoh.mode, Mode::Client);
    let connect = configuration.zenoh.connect.unwrap();
    assert_eq!(connect.0, ["tcp/127.0.0.1:7447"]);
    for (assignments, port) in [
        (vec![], 7447),
        (vec!["zenoh.listen=tcp/127.0.0.1:7448".to_owned()], 7448),
    ] {
        let router = load_router(&assignments).unwrap();
        assert_eq!(router.mode, Mode::Router);
        assert_eq!(router.listen.0, [format!("tcp/127.0.0.1:{port}")]);
        assert_eq!(router.connect, Some(Endpoints::default()));
    }
}

#[test]
fn messages_are_as_large_as_those_of_the_protocol_and_usual_clouds_by_default() {
    let zenoh = set(&[]).zenoh;
    let said = |zenoh: ZenohSettings| -> usize {
        let config = zenoh.to_zenoh().unwrap();
        let said = config.get_json("transport/link/rx/max_message_size");
        said.unwrap().parse().unwrap()
    };
    let most = said(zenoh.clone());
    // A million points with colour.
    let usual = MAX_MESSAGE_BYTES.max(32_000_000);
    assert!((usual..usual + (4 << 20)).contains(&most));
    assert!(said(zenoh.with_largest_clouds()) > MAX_CLOUD_BYTES);
}

#[test]
fn a_link_is_closed_when_its_certificate_ends() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("certificate.pem");
    std::fs::write(&path, include_str!("certificate.pem")).unwrap();
    let given = ["certificate", "root_ca"].map(|of| format!("zenoh.tls.{of}={}", path.display()));
    let with = vec![&*given[0], &*given[1], "zenoh.connect=tls/a:1"];
    for (assignments, closes) in [(with, "true"), (vec![], "null")] {
        let zenoh = set(&assignments).zenoh.to_zenoh().unwrap();
        let said = zenoh.get_json("transport/link/tls/close_link_on_expiration");
        assert_eq!(said.unwrap(), closes);
    }
}

/// Loads a router with a certificate and an authority, and with the files of a folder by their
/// names.
fn load_secure_router(folder: &Path, assignments: &[&str]) -> Result<(), ConfigurationError> {
    let certificate = folder.join("certificate.pem");
    std::fs::write(&certificate, include_str!("certificate.pem")).unwrap();
    let own = [
        "certificate=FOLDER/certificate.pem",
        "root_ca=FOLDER/certificate.pem",
    ];
    let own = own.map(|file| format!("zenoh.tls.{file}"));
    let given = assignments.iter().map(|&given| given.to_owned());
    let all = own.into_iter().chain(given);
    let all: Vec<String> = all
        .map(|it| it.replace("FOLDER", folder.to_str().unwrap()))
        .collect();
    load_router(&all).map(drop)
}

const CLOSED: &str = "{access_control: {enabled: true, default_permission: 'deny'}}";

#[test]
fn a_router_with_a_certificate_denies_by_default_or_does_not_start() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let plain = CLOSED.replace("}}", "}, listen: {endpoints: {router: ['tcp/a:1']}}}");
    for (name, text) in [
        ("none", "{}"),
        ("open", &CLOSED.replace("deny", "allow")),
        ("off", &CLOSED.replace("true", "false")),
        ("closed", CLOSED),
        ("plain", &plain),
    ] {
        std::fs::write(folder.join(format!("{name}.json5")), text).unwrap();
    }
    let tls = "zenoh.listen=tls/0.0.0.0:7447";
    let [closed, plain] = [
        "zenoh.file=FOLDER/closed.json5",
        "zenoh.file=FOLDER/plain.json5",
    ];
    for (assignments, key) in [
        (vec![tls], "zenoh.file: "),
        (vec![tls, "zenoh.file=FOLDER/none.json5"], "zenoh.file: "),
        (vec![tls, "zenoh.file=FOLDER/open.json5"], "zenoh.file: "),
        (vec![tls, "zenoh.file=FOLDER/off.json5"], "zenoh.file: "),
        (vec![closed], "zenoh.listen: "),
        (vec!["zenoh.listen=[]", plain], "zenoh.listen: "),
        (
            vec!["zenoh.listen=tls/a:1, tcp/a:2", closed],
            "zenoh.listen: ",
        ),
        (
            vec![tls, closed, "zenoh.connect=tcp/b:1"],
            "zenoh.connect: ",
        ),
    ] {
        let refused = load_secure_router(folder, &assignments)
            .unwrap_err()
            .to_string();
        assert!(refused.starts_with(key), "{assignments:?}: {refused}");
    }
    load_secure_router(folder, &[tls, closed]).unwrap();
}

#[test]
fn a_key_that_others_may_read_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let key = folder.path().join("key.pem");
    std::fs::write(&key, "").unwrap();
    std::fs::write(folder.path().join("closed.json5"), CLOSED).unwrap();
    let assignments = [
        "zenoh.listen=tls/0.0.0.0:7447",
        "zenoh.file=FOLDER/closed.json5",
        "zenoh.tls.private_key=FOLDER/key.pem",
    ];
    for (mode, is_refused) in [
        (0o600, false),
        // As Kubernetes hands out secrets.
        (0o440, false),
        (0o644, true),
        (0o660, true),
    ] {
        std::fs::set_permissions(&key, Permissions::from_mode(mode)).unwrap();
        let loaded = load_secure_router(folder.path(), &assignments);
        let told = loaded.map_err(|error| error.to_string()).err();
        let remedy = format!("chmod 600 {}", key.display());
        let names_it = told.as_ref().map(|told| told.contains(&remedy));
        assert_eq!(names_it, is_refused.then_some(true), "{mode:o}: {told:?}");
    }
}

#[test]
fn wrong_settings_are_refused_with_key_and_origin() {
    let refused = |file, environment: &[_], set: &[_], parts: &[&str]| {
        let error = load(file, environment, set).unwrap_err().to_string();
        for part in parts {
            assert!(error.contains(part), "'{part}' is not in: {error}");
        }
    };
    for (file, parts) in [
        ("[zenoh]\nmoed = 'peer'", ["zenoh.moed", "unknown field"]),
        ("[service]\nthreads = 'many'", ["service.threads", "many"]),
        ("[zenoh\n", ["not TOML", "line 1"]),
    ] {
        refused(Some(file), &[], &[], &[parts[0], parts[1], "c.toml"]);
    }
    let variable = "PPNPACK__ADMIN__PORT";
    let origin = format!("environment variable {variable}");
    refused(None, &[(variable, "1")], &[], &["admin.port", &origin]);
    let retention = "[service.store]\ndays = 3\nbackup.every_s = 'often'";
    let parts = ["service.store.backup.every_s:", "often", "c.toml"];
    refused(Some(retention), &[], &["service.threads=2"], &parts);
    let set = ["service.store.folder=a", "service.store.days=many"];
    let parts = ["service.store.days:", "many", "--set service.store.days"];
    refused(None, &[], &set, &parts);
    for (set, parts) in [
        (
            "service.store.file=x",
            "service.store.file; --set service.store.file",
        ),
        ("zenoh.mode=server", "zenoh.mode; server; client; --set"),
        ("admin.listen=9100", "admin.listen; --set"),
        ("nonsense", "nonsense; KEY=VALUE"),
        ("service.threads=65", "service; threads; 64"),
        ("instance=A b", "instance"),
        ("shutdown_grace_s=-1", "shutdown_grace_s"),
        ("log.filter=a=b=c", "log.filter"),
        ("telemetry.otlp=collector:4318", "telemetry.otlp; http://"),
        ("zenoh.connect=[]", "zenoh.connect; tcp/127.0.0.1:7447"),
        ("zenoh.connect=carrier-pigeon", "zenoh.connect"),
        ("zenoh.mode=router", "zenoh.listen"),
        ("zenoh.user=me", "zenoh.user; password"),
        ("zenoh.password=secret", "zenoh.password; a file"),
        ("zenoh.connect=tls/a:1", "zenoh.tls.root_ca; tls/"),
        ("zenoh.namespace=a/*", "zenoh.namespace"),
        (
            "zenoh.tls.root_ca=/no/such/file",
            "zenoh.tls.root_ca; /no/such/file",
        ),
    ] {
        let parts: Vec<&str> = parts.split("; ").collect();
        refused(None, &[], &[set], &parts);
    }
    let missing = Sources {
        file: Some(Path::new("/no/such/file")),
        ..Sources::default()
    };
    let error = Configuration::<Settings>::load(Service::Ppn, &missing).unwrap_err();
    assert!(error.to_string().contains("/no/such/file"), "{error}");
}

#[test]
fn what_is_printed_can_be_read_again_and_shows_no_secret() {
    let assignments = [
        "zenoh.user=me",
        "zenoh.namespace=plant-2",
        "telemetry.otlp=http://127.0.0.1:4318/v1/traces",
        "service.share=0.25",
    ];
    let password = [("PPNPACK__ZENOH__PASSWORD", "12345")];
    let configuration = load(None, &password, &assignments).unwrap();
    let password = configuration.zenoh.password.as_ref();
    assert_eq!(password.map(Secret::reveal), Some("12345"));
    let text = configuration.to_toml().unwrap();
    assert!(
        !text.contains("12345") && text.contains("password = \"***\""),
        "{text}"
    );
    assert!(!format!("{configuration:?}").contains("12345"));
    let again = load(Some(&text), &[], &[]).unwrap();
    assert_eq!(again.to_toml().unwrap(), text);
    assert_eq!(again.hash(), configuration.hash());
    let password = [("PPNPACK__ZENOH__PASSWORD", "[\"12345\"]")];
    let error = load(None, &password, &["zenoh.user=me"]).unwrap_err();
    assert!(!error.to_string().contains("12345"), "{error}");
}

#[test]
fn the_hash_tells_settings_apart_but_not_replicas() {
    let hash = |assignments: &[&str]| set(assignments).hash();
    assert_eq!(hash(&[]).len(), 16);
    assert_eq!(hash(&["instance=a"]), hash(&["instance=b"]));
    assert_ne!(hash(&[]), hash(&["service.threads=2"]));
}
