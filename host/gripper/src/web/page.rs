//! The page as one document.

/// The page.
pub fn page() -> String {
    include_str!("page.html")
        .replace("/*STYLE*/", include_str!("page.css"))
        .replace("/*SCRIPT*/", concat!(include_str!("page.js"), include_str!("margin.js")))
}
