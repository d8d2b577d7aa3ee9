//! Addresses of cameras and streams as they may be shown: they may hold a user's name, a password or a key, and messages and pages are
//! passed on.

/// What stands in place of a query's values.
const HIDDEN: &str = "hidden";
/// What a sentence puts behind an address.
const PUNCTUATION: [char; 8] = [':', ';', ',', '.', ')', '\'', '"', '`'];

/// A text with every address in it (`rtsp://name:password@host/path?key=value`) without the name and password of its user and without
/// the values of its query, of which nothing says which are secret.
///
/// An address's host ends at the first `/` or white space, as for ffmpeg; what stands before the last `@` ahead of that is the user.
/// Where no such user is found and what follows the host's colon is no port, a `/` or a space of the password ended the host too early: the
/// user then goes on to the next `@` of the line. A query goes on to the next white space.
///
/// It is the one way by which the input of a run comes into messages and files. Limits: a password that begins as a port does and goes on
/// with a `/` or a space, and words without `://`, are shown as they are.
pub fn without_credentials(text: &str) -> String {
    let (mut shown, mut rest) = (String::new(), text);
    while let Some((before, address)) = rest.split_once("://") {
        shown += before;
        shown += "://";
        rest = &address[user_bytes(address)..];
        let path_bytes = rest.find(|c: char| c == '?' || c.is_whitespace()).unwrap_or(rest.len());
        let (path, behind) = rest.split_at(path_bytes);
        if let Some(query) = behind.strip_prefix('?').filter(|_| !path.contains("://")) {
            let (query, behind) = query.split_at(query.find(char::is_whitespace).unwrap_or(query.len()));
            shown += path;
            shown += "?";
            shown += &without_values(query);
            rest = behind;
        }
    }
    shown + rest
}

/// Bytes of the user at the start of an address behind its `://`, with the `@` behind them.
fn user_bytes(address: &str) -> usize {
    let mut user_bytes = 0;
    loop {
        let rest = &address[user_bytes..];
        let authority = &rest[..rest.find(|c: char| c == '/' || c.is_whitespace()).unwrap_or(rest.len())];
        if let Some(at) = authority.rfind('@') {
            return user_bytes + at + 1;
        }
        let in_line = rest.lines().next().and_then(|line| line.find('@'));
        match in_line.filter(|_| !names_a_host(authority)) {
            Some(at) => user_bytes += at + 1,
            None => return user_bytes,
        }
    }
}

/// Whether what stands before a path may be a host, with its port or a sentence's punctuation behind it.
fn names_a_host(authority: &str) -> bool {
    let behind_brackets = authority.rsplit(']').next().unwrap_or_default();
    let (_, port) = behind_brackets.trim_end_matches(PUNCTUATION).split_once(':').unwrap_or_default();
    port.bytes().all(|byte| byte.is_ascii_digit())
}

/// A query's keys, and the punctuation of the sentence that it ends in.
fn without_values(query: &str) -> String {
    let given = query.trim_end_matches(PUNCTUATION);
    let hidden = given.split('&').map(|pair| match pair.split_once('=') {
        Some((key, _)) => format!("{key}={HIDDEN}"),
        None => HIDDEN.to_owned(),
    });
    hidden.collect::<Vec<_>>().join("&") + &query[given.len()..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_secret_is_left_of_any_address_and_all_else_stays() {
        for (text, shown) in [
            ("rtsp://me:p@ss@10.0.0.4:554/a@b", "rtsp://10.0.0.4:554/a@b"),
            ("rtsp://me@[::1]:554", "rtsp://[::1]:554"),
            ("rtsp://[::1]:554/a@b", "rtsp://[::1]:554/a@b"),
            ("rtsp://me:pä?#:\\'ss@camera", "rtsp://camera"),
            (
                "[in#0] Error opening rtsp://me:secret@camera/1: refused; see http://a:b@proxy\nwrite to me@home",
                "[in#0] Error opening rtsp://camera/1: refused; see http://proxy\nwrite to me@home",
            ),
            ("m@p.osm", "m@p.osm"),
            ("http://host/://me@b", "http://host/://b"),
            ("", ""),
            ("://", "://"),
            // A password with what ends a host.
            ("rtsp://me:pa/ss@camera/a@b", "rtsp://camera/a@b"),
            ("rtsp://me:p/a@ss@camera:554/1", "rtsp://camera:554/1"),
            (
                "unexpected argument 'rtsp://me:pa ss@camera/1' found",
                "unexpected argument 'rtsp://camera/1' found",
            ),
            ("rtsp://me:p/ /@camera", "rtsp://camera"),
            ("rtsp://camera: refused; write to me@home", "rtsp://camera: refused; write to me@home"),
            ("rtsp://camera:554: refused (me@home)", "rtsp://camera:554: refused (me@home)"),
            ("rtsp://me:pass refused\nwrite to me@home", "rtsp://me:pass refused\nwrite to me@home"),
            // A query.
            (
                "http://camera/video?user=me&password=s/e=c?r@t: refused",
                "http://camera/video?user=hidden&password=hidden: refused",
            ),
            ("'rtsp://me:a@camera?s3cret'", "'rtsp://camera?hidden'"),
            ("http://a/?u=rtsp://me:b@c/d&password=e f?g", "http://a/?u=hidden&password=hidden f?g"),
            ("is it a.mp4?", "is it a.mp4?"),
        ] {
            assert_eq!(without_credentials(text), shown);
            assert_eq!(without_credentials(shown), shown);
        }
    }
}
