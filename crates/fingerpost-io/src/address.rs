//! Addresses of cameras and streams as they may be shown: they may hold a user's name and password, messages and pages are passed on.

/// A text with every address in it (`rtsp://name:password@host/path`) without the name and password of its user. An address's host
/// ends at the first `/` or white space, as for ffmpeg; what stands before the last `@` ahead of that is the user.
///
/// It is the one way by which the input of a run comes into messages and files.
pub fn without_users(text: &str) -> String {
    let mut parts = text.split("://");
    let mut shown = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let authority = &part[..part.find(|c: char| c == '/' || c.is_whitespace()).unwrap_or(part.len())];
        let user = authority.rfind('@').map_or(0, |at| at + 1);
        shown += "://";
        shown += &part[user..];
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_user_is_left_of_any_address_and_all_else_stays() {
        for (text, shown) in [
            ("rtsp://me:p@ss@10.0.0.4:554/a@b", "rtsp://10.0.0.4:554/a@b"),
            ("rtsp://me@[::1]:554", "rtsp://[::1]:554"),
            ("rtsp://me:pä?#:\\'ss@camera", "rtsp://camera"),
            (
                "[in#0] Error opening rtsp://me:secret@camera/1: refused; see http://a:b@proxy\nwrite to me@home",
                "[in#0] Error opening rtsp://camera/1: refused; see http://proxy\nwrite to me@home",
            ),
            ("m@p.osm", "m@p.osm"),
            ("http://host/://me@b", "http://host/://b"),
            ("", ""),
            ("://", "://"),
        ] {
            assert_eq!(without_users(text), shown);
            assert_eq!(without_users(shown), shown);
        }
    }
}
