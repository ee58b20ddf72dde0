//! The page on which people rate: three fixed files that fetch nothing from elsewhere.

/// The document.
pub const HTML: &str = include_str!("../page/index.html");
/// Its style.
pub const STYLE: &str = include_str!("../page/style.css");
/// Its script.
pub const SCRIPT: &str = include_str!("../page/script.js");
/// The Content-Security-Policy of every answer: own script, style and images, and nothing else at all.
pub const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; \
                          base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

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
