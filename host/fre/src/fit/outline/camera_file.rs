//! A camera in a TOML file.

use std::path::Path;

use super::camera::Camera;
use super::error::OutlineError;

/// Reads a file that holds a camera's [`text`].
///
/// # Errors
/// It cannot be read, is not TOML, or a key is missing or unknown.
pub fn read(path: &Path) -> Result<Camera, OutlineError> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path)
        .map_err(|error| OutlineError::Unreadable { file: file.clone(), reason: error.to_string() })?;
    toml::from_str(&text).map_err(|error| OutlineError::toml(&file, &text, &error))
}

/// The camera as a file has it, one key a line.
pub fn text(camera: &Camera) -> String {
    let list = |values: &[f64]| values.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ");
    let [width, height] = camera.size_px;
    format!(
        "size_px = [{width}, {height}]\nfocal_px = [{}]\ncentre_px = [{}]\nradial = [{}]\ntangential = [{}]\n",
        list(&camera.focal_px),
        list(&camera.centre_px),
        list(&camera.radial),
        list(&camera.tangential)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_is_read_as_it_is_written() {
        let camera = Camera {
            size_px: [4000, 3000],
            focal_px: [3100.25, 3099.5],
            centre_px: [1999.5, 1499.5],
            radial: [-0.12, 1e-7],
            tangential: [0.001, -0.002],
        };
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("camera.toml");
        std::fs::write(&file, text(&camera)).unwrap();
        assert_eq!(read(&file).unwrap(), camera);
        std::fs::write(&file, text(&camera).replace("radial", "radiol")).unwrap();
        let error = read(&file).unwrap_err().to_string();
        assert!(error.contains("camera.toml:4: unknown field `radiol`"), "{error}");
    }
}
