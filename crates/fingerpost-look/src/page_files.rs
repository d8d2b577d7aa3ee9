//! The files of the pages.

use fingerpost_server::Answer;

/// Type of a style sheet.
const STYLE: &str = "text/css; charset=utf-8";

/// The markup of a page by the name of its module: its body in what all pages have in common.
pub(crate) fn markup(name: &str) -> Answer {
    let (title, style, body) = match name {
        "look" => ("look at a run", "parts", include_str!("page/look.html")),
        "feel" => ("feel the settings", "parts", include_str!("page/feel.html")),
        "compare" => ("compare two runs", "parts", include_str!("page/compare.html")),
        "mount" => ("set a drive up", "mount", include_str!("page/mount.html")),
        _ => return Answer::refused(404, "there is no such page; open / instead"),
    };
    let filled = [("{title}", title), ("{style}", style), ("{name}", name), ("{body}", body)];
    let page = include_str!("page/page.html").to_owned();
    let page = filled.iter().fold(page, |page, (place, text)| page.replace(place, text));
    Answer::text("text/html; charset=utf-8", &page)
}

/// A style sheet or module of a page.
pub(crate) fn page_file(name: &str) -> Answer {
    let text = match name {
        "look.css" => return Answer::text(STYLE, include_str!("page/look.css")),
        "mount.css" => return Answer::text(STYLE, include_str!("page/mount.css")),
        "parts.css" => return Answer::text(STYLE, include_str!("page/parts.css")),
        "look.js" => include_str!("page/look.js"),
        "dom.js" => include_str!("page/dom.js"),
        "frames.js" => include_str!("page/frames.js"),
        "shapes.js" => include_str!("page/shapes.js"),
        "curves.js" => include_str!("page/curves.js"),
        "feel.js" => include_str!("page/feel.js"),
        "compare.js" => include_str!("page/compare.js"),
        "frame_view.js" => include_str!("page/frame_view.js"),
        "columns.js" => include_str!("page/columns.js"),
        "settings.js" => include_str!("page/settings.js"),
        "numbers.js" => include_str!("page/numbers.js"),
        "mount.js" => include_str!("page/mount.js"),
        "map_view.js" => include_str!("page/map_view.js"),
        "fix_map.js" => include_str!("page/fix_map.js"),
        "route_map.js" => include_str!("page/route_map.js"),
        "search.js" => include_str!("page/search.js"),
        _ => return Answer::refused(404, "there is no such file of the page"),
    };
    Answer::text("text/javascript; charset=utf-8", text)
}
