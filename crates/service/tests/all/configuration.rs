//! Configurations from several sources.

use std::path::Path;

use ppnpack_service::configuration::{
    AdminListen, Configuration, ConfigurationError, Endpoints, Mode, Secret, ServiceSettings,
    Sources, ZenohSettings,
};
use ppnpack_wire::keys::Service;
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
    assert_eq!(
        (configuration.service.threads, configuration.service.share),
        (3, 1.0)
    );
    assert_eq!(configuration.service.store.folder, "/a");
    let zenoh = configuration.zenoh;
    assert_eq!(zenoh.mode, Mode::Peer);
    let connect = ["tcp/a:1", "tcp/b:2"].map(str::to_owned);
    assert_eq!(zenoh.connect, Some(Endpoints(connect.to_vec())));
}

#[test]
fn nothing_given_is_a_client_on_this_machine() {
    let configuration = load(None, &[], &[]).unwrap();
    assert_eq!(configuration.instance, "planner-1");
    assert_eq!(configuration.zenoh.mode, Mode::Client);
    assert_eq!(
        configuration.zenoh.connect.unwrap().0,
        ["tcp/127.0.0.1:7447"]
    );
}

#[test]
fn a_link_is_closed_when_its_certificate_ends() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("certificate.pem");
    std::fs::write(&path, include_str!("certificate.pem")).unwrap();
    let given = format!("zenoh.tls.certificate={}", path.display());
    for (assignments, closes) in [(vec![given.as_str()], "true"), (vec![], "null")] {
        let zenoh = load(None, &[], &assignments).unwrap().zenoh;
        let zenoh = zenoh.to_zenoh().unwrap();
        let said = zenoh.get_json("transport/link/tls/close_link_on_expiration");
        assert_eq!(said.unwrap(), closes);
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
            "service.store.file; option --set service.store.file",
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
    let error = Configuration::<Settings>::load(Service::Ppn, &missing)
        .unwrap_err()
        .to_string();
    assert!(error.contains("/no/such/file"), "{error}");
}

#[test]
fn what_is_printed_can_be_read_again_and_shows_no_secret() {
    let assignments = [
        "zenoh.user=me",
        "zenoh.password=12345",
        "zenoh.namespace=plant-2",
        "telemetry.otlp=http://127.0.0.1:4318/v1/traces",
        "service.share=0.25",
    ];
    let configuration = load(None, &[], &assignments).unwrap();
    assert_eq!(
        configuration.zenoh.password.as_ref().map(Secret::reveal),
        Some("12345")
    );
    let text = configuration.to_toml().unwrap();
    assert!(
        !text.contains("12345") && text.contains("password = \"***\""),
        "{text}"
    );
    assert!(!format!("{configuration:?}").contains("12345"));
    let again = load(Some(&text), &[], &[]).unwrap();
    assert_eq!(again.to_toml().unwrap(), text);
    assert_eq!(again.hash(), configuration.hash());
    let error = load(None, &[], &["zenoh.user=me", "zenoh.password=[\"12345\"]"]).unwrap_err();
    assert!(!error.to_string().contains("12345"), "{error}");
}

#[test]
fn the_hash_tells_settings_apart_but_not_replicas() {
    let hash = |assignments: &[&str]| load(None, &[], assignments).unwrap().hash();
    assert_eq!(hash(&[]).len(), 16);
    assert_eq!(hash(&["instance=a"]), hash(&["instance=b"]));
    assert_ne!(hash(&[]), hash(&["service.threads=2"]));
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

#[test]
fn a_service_has_its_own_way_to_zenoh_where_nothing_else_is_said() {
    let load = |assignments: &[String]| {
        let sources = Sources {
            assignments,
            ..Sources::default()
        };
        Configuration::<RouterSettings>::load(Service::Router, &sources)
            .unwrap()
            .zenoh
    };
    let default = load(&[]);
    assert_eq!(
        (default.mode, default.listen.0),
        (Mode::Router, vec!["tcp/127.0.0.1:7447".to_owned()])
    );
    assert_eq!(default.connect, Some(Endpoints::default()));
    let moved = load(&["zenoh.listen=tcp/127.0.0.1:7448".to_owned()]);
    assert_eq!(
        (moved.mode, moved.listen.0),
        (Mode::Router, vec!["tcp/127.0.0.1:7448".to_owned()])
    );
}
