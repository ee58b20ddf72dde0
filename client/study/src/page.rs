//! The page on which people rate: three fixed files that fetch nothing from elsewhere.

/// The document.
pub const HTML: &str = include_str!("../page/index.html");
/// Its style.
pub const STYLE: &str = include_str!("../page/style.css");
/// Its script.
pub const SCRIPT: &str = include_str!("../page/script.js");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_names_no_other_host_and_holds_nothing_inline() {
        for text in [HTML, STYLE, SCRIPT] {
            assert!(!text.contains("http:") && !text.contains("https:") && !text.contains("innerHTML"));
        }
        assert!(!HTML.contains("style=") && !HTML.contains("onclick") && !HTML.contains("<script>"));
    }
}
