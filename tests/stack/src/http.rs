//! The operator's page as a program asks for it: as little of HTTP as that takes.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use serde_json::{Value, json};

/// The maximum time for anything here.
const PATIENCE: Duration = Duration::from_secs(60);

#[derive(Debug, Clone)]
pub(crate) struct Page {
    pub(crate) address: SocketAddr,
    token: Option<String>,
}

#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    /// The headers by their names in small letters.
    pub(crate) headers: BTreeMap<String, String>,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    /// The status, and the name of the error.
    pub(crate) fn error(&self) -> (u16, String) {
        let body: Value = serde_json::from_slice(&self.body).unwrap_or_default();
        let name = body["error"].as_str().unwrap_or_default();
        (self.status, name.to_owned())
    }

    pub(crate) fn json(&self) -> Value {
        let body = String::from_utf8_lossy(&self.body);
        serde_json::from_str(&body).unwrap_or_else(|error| panic!("no JSON: {error}: {body}"))
    }
}

impl Page {
    pub(crate) fn at(address: SocketAddr) -> Self {
        Self {
            address,
            token: None,
        }
    }

    /// The same page for somebody who has a token.
    #[must_use]
    pub(crate) fn with_token(&self, token: &str) -> Self {
        Self {
            token: Some(token.to_owned()),
            ..self.clone()
        }
    }

    pub(crate) fn get(&self, path: &str) -> Answer {
        self.get_of_host(path, &self.address.to_string())
    }

    /// Asks for something of a host by another name.
    pub(crate) fn get_of_host(&self, path: &str, host: &str) -> Answer {
        self.ask(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n"), "")
    }

    pub(crate) fn control(&self, action: &str, order: &Value) -> Answer {
        let host = self.address;
        let token = self.token.as_ref();
        let token = token.map(|token| format!("Authorization: Bearer {token}\r\n"));
        let token = token.unwrap_or_default();
        let head = format!(
            "POST /api/control/{action} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nContent-Type: application/json\r\n{token}"
        );
        self.ask(&head, &order.to_string())
    }

    pub(crate) fn watch(&self) -> Result<Watch> {
        let host = self.address;
        let mut reader = self.send(&format!("GET /api/events HTTP/1.1\r\nHost: {host}\r\n"), "")?;
        let (status, _) = head(&mut reader)?;
        ensure!(status == 200, "the events are refused with {status}");
        let mut watch = Watch {
            reader,
            parts: BTreeMap::new(),
            beats: 0,
        };
        watch.next()?;
        Ok(watch)
    }

    fn ask(&self, request: &str, body: &str) -> Answer {
        let reader = self.send(&format!("{request}Connection: close\r\n"), body);
        let mut reader = reader.unwrap();
        let (status, headers) = head(&mut reader).unwrap();
        let mut body = Vec::new();
        let length = headers["content-length"].parse().unwrap();
        reader.take(length).read_to_end(&mut body).unwrap();
        Answer {
            status,
            headers,
            body,
        }
    }

    fn send(&self, request: &str, body: &str) -> Result<BufReader<TcpStream>> {
        let mut stream = TcpStream::connect_timeout(&self.address, PATIENCE)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        let length = body.len();
        stream.write_all(format!("{request}Content-Length: {length}\r\n\r\n{body}").as_bytes())?;
        Ok(BufReader::new(stream))
    }
}

/// Reads the status and the headers of an answer.
fn head(reader: &mut impl BufRead) -> Result<(u16, BTreeMap<String, String>)> {
    let status = line(reader)?;
    let status = status.split(' ').nth(1).context("no answer of HTTP")?;
    Ok((status.parse()?, headers(reader)?))
}

/// Reads the headers of a request or an answer, behind its first line.
pub(crate) fn headers(reader: &mut impl BufRead) -> Result<BTreeMap<String, String>> {
    let mut headers = BTreeMap::new();
    loop {
        let line = line(reader)?;
        match line.split_once(": ") {
            Some((name, value)) => headers.insert(name.to_lowercase(), value.to_owned()),
            None => return Ok(headers),
        };
    }
}

/// Reads a line without its end.
pub(crate) fn line(reader: &mut impl BufRead) -> Result<String> {
    let mut line = String::new();
    ensure!(reader.read_line(&mut line)? > 0, "the connection ended");
    Ok(line.trim_end().to_owned())
}

/// A connected page, whose parts change.
pub(crate) struct Watch {
    reader: BufReader<TcpStream>,
    parts: BTreeMap<String, Value>,
    pub(crate) beats: usize,
}

impl Watch {
    /// A part of a cell, or of its container of the same name; nothing where there is none.
    pub(crate) fn part(&self, of: &str, part: &str) -> &Value {
        self.parts
            .get(&format!("{of}/{part}"))
            .unwrap_or(&Value::Null)
    }

    /// Waits until the parts are as wanted.
    pub(crate) fn until(&mut self, what: &str, is_wanted: impl Fn(&Self) -> bool) {
        let deadline = Instant::now() + PATIENCE;
        while !is_wanted(self) {
            let is_in_time = Instant::now() <= deadline;
            assert!(is_in_time, "{what} is not shown: {}", json!(self.parts));
            self.next().unwrap();
        }
    }

    fn next(&mut self) -> Result<()> {
        let (mut event, mut data) = (String::new(), String::new());
        loop {
            // The body comes in chunks, whose lengths stand in lines of their own.
            let line = line(&mut self.reader)?;
            if let Some(name) = line.strip_prefix("event: ") {
                name.clone_into(&mut event);
            } else if let Some(text) = line.strip_prefix("data: ") {
                text.clone_into(&mut data);
            } else if line.is_empty() && !data.is_empty() {
                break;
            }
        }
        let data: Value = serde_json::from_str(&data)?;
        match event.as_str() {
            "snapshot" => {
                self.parts.clear();
                let parts = data.get("parts").and_then(Value::as_array);
                let parts = parts.context("a snapshot without parts")?;
                parts.iter().for_each(|part| self.take(part));
            }
            "part" => self.take(&data),
            "beat" => self.beats += 1,
            other => bail!("an event '{other}'"),
        }
        Ok(())
    }

    fn take(&mut self, part: &Value) {
        let text = |field: &str| part[field].as_str().unwrap_or_default().to_owned();
        let of = match part["container"].as_str() {
            Some(container) => container.to_owned(),
            None => text("cell"),
        };
        self.parts
            .insert(format!("{of}/{}", text("part")), part["value"].clone());
    }
}
