//! A mesh to write, whole or broken.

/// A cube of 5 cm as ASCII PLY, with replacements to break it.
pub(crate) fn cube_ply(replace: &[(&str, &str)]) -> String {
    let mut ply = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
        element face 12\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n0.05 0 0\n0.05 0.05 0\n0 0.05 0\n0 0 0.05\n0.05 0 0.05\n0.05 0.05 0.05\n0 0.05 0.05\n\
        3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n"
        .to_owned();
    for (from, to) in replace {
        assert!(ply.contains(from), "{from}");
        ply = ply.replacen(from, to, 1);
    }
    ply
}
