//! One HTTP exchange, for the health check and the traces. Both block, go to a neighbour in plain
//! HTTP and read little, for which a client library with pools and TLS would be a dependency more.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

const MAX_ANSWER_BYTES: u64 = 64 << 10;

#[derive(Debug, PartialEq)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) body: String,
}

/// Sends a request and reads the answer. `head`: the request line and headers but length and host,
/// each with line end.
pub(crate) fn exchange(
    authority: &str,
    head: &str,
    body: &[u8],
    timeout: Duration,
) -> io::Result<Answer> {
    let address = authority
        .to_socket_addrs()?
        .next()
        .ok_or_else(|| io::Error::other(format!("{authority} has no address")))?;
    let mut stream = TcpStream::connect_timeout(&address, timeout)?;
    stream.set_read_timeout(Some(timeout))?;
    stream.set_write_timeout(Some(timeout))?;
    let length = body.len();
    let fixed =
        format!("Host: {authority}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n");
    stream.write_all(&[head.as_bytes(), fixed.as_bytes(), body].concat())?;
    let mut answer = Vec::new();
    stream.take(MAX_ANSWER_BYTES).read_to_end(&mut answer)?;
    parse(&String::from_utf8_lossy(&answer)).ok_or_else(|| io::Error::other("no answer of HTTP"))
}

fn parse(answer: &str) -> Option<Answer> {
    let (head, body) = answer.split_once("\r\n\r\n")?;
    let first = head.lines().next()?.strip_prefix("HTTP/1.")?;
    let status = first.split(' ').nth(1)?.parse().ok()?;
    let body = body.to_owned();
    Some(Answer { status, body })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_taken_apart() {
        let answer = parse("HTTP/1.1 503 Service Unavailable\r\nA: b\r\n\r\n{}").unwrap();
        assert_eq!((answer.status, answer.body.as_str()), (503, "{}"));
        for head in ["", "SSH-2.0 x\r\n\r\n", "HTTP/1.1 x\r\n\r\n"] {
            assert_eq!(parse(head), None, "{head}");
        }
        assert_eq!(parse("HTTP/1.1 200 OK"), None);
    }
}
