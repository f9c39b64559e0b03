//! The command that makes a film of pictures.

use std::path::Path;

/// A line for a POSIX shell that makes the film `film` of the pictures in `folder` ([`Frames`](super::Frames)), from
/// number `first` on, so many a second. Players want yuv420p, which wants even sizes: an odd picture gets a row more.
pub fn film_command(folder: &Path, first: u32, per_second: u32, film: &Path) -> String {
    // ffmpeg reads the whole path as a pattern.
    let pattern = with_folder(folder).replace('%', "%%") + "/frame-%05d.png";
    format!(
        "ffmpeg -framerate {per_second} -start_number {first} -i {} -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' \
         -c:v libx264 -crf 18 -pix_fmt yuv420p -movflags +faststart {}",
        quoted(&pattern),
        quoted(&with_folder(film)),
    )
}

/// A path that begins with a folder: one that begins with - would be an option, one with a colon a protocol.
fn with_folder(path: &Path) -> String {
    let text = path.display().to_string();
    let text = text.trim_end_matches('/');
    match () {
        () if path.has_root() || text.starts_with("./") || text.starts_with("../") => text.into(),
        () if text.is_empty() => ".".into(),
        () => format!("./{text}"),
    }
}

/// A word of a shell.
fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_quoted_and_no_options() {
        let command = |folder: &str, film: &str| {
            let command = film_command(folder.as_ref(), 7, 30, film.as_ref());
            let paths = command
                .strip_prefix("ffmpeg -framerate 30 -start_number 7 -i ")
                .expect("the beginning");
            let (input, rest) = paths.split_once(" -vf ").expect("a filter");
            assert!(rest.contains("-pix_fmt yuv420p "));
            let output = rest.split_once(" +faststart ").expect("the end").1;
            [input.to_string(), output.to_string()]
        };
        assert_eq!(
            command("target/film", "film.mp4"),
            ["'./target/film/frame-%05d.png'", "'./film.mp4'"]
        );
        assert_eq!(
            command("/a b/it's 5 % $HOME/", "-y.mp4"),
            [r"'/a b/it'\''s 5 %% $HOME/frame-%05d.png'", "'./-y.mp4'"]
        );
        assert_eq!(
            command("../a:b", "a:b.mp4"),
            ["'../a:b/frame-%05d.png'", "'./a:b.mp4'"]
        );
    }

    /// A shell takes each path for one word, whatever is in it.
    #[cfg(unix)]
    #[test]
    fn a_shell_reads_them_as_they_were() {
        let folder = "/x y/'\"$(date)`\\;#*\n/z";
        let command = film_command(folder.as_ref(), 0, 25, "a'b c.mp4".as_ref());
        let words = command.replacen("ffmpeg", "printf '%s\\0'", 1);
        let output = std::process::Command::new("sh")
            .args(["-c", &words])
            .output()
            .expect("a shell");
        let text = String::from_utf8(output.stdout).expect("text");
        let words: Vec<&str> = text.split('\0').collect();
        assert!(words.contains(&format!("{folder}/frame-%05d.png").as_str()));
        assert!(words.contains(&"./a'b c.mp4") && words.contains(&"yuv420p"));
    }
}
