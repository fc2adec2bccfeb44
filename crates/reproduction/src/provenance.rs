//! Facts about this run that another run need not share: commit, compiler, target, clock. They stand in `run` of
//! `results.json` and in one block of the page, and nowhere else.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

use report::Run;

/// Facts about the run that started now; `seconds` are filled in by whoever has them.
#[must_use]
pub fn run(root: &Path) -> Run {
    Run {
        commit: git(root, &["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown".to_owned()),
        dirty: git(root, &["status", "--porcelain"]).is_none_or(|changes| !changes.is_empty()),
        rustc: env!("BRISTLE_RUSTC").to_owned(),
        target: env!("BRISTLE_TARGET").to_owned(),
        started: now(),
        finished: String::new(),
        seconds: BTreeMap::new(),
        link: link(),
    }
}

/// The time in ISO 8601, to the second.
#[must_use]
pub fn now() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    iso_8601(since.map_or(0, |since| since.as_secs()))
}

/// What git says about the repository; `None` without git or outside a repository.
fn git(root: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new("git")
        .arg("-C")
        .arg(root)
        .args(arguments)
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

/// Public address of the repository, to which lines of code can be linked: as GitHub states it, else that of the remote
/// `origin` where it is a web address or GitHub's own short form.
#[must_use]
pub fn repository(root: &Path) -> Option<String> {
    let part = |name: &str| std::env::var(name).ok();
    part("GITHUB_SERVER_URL")
        .zip(part("GITHUB_REPOSITORY"))
        .map(|(server, name)| format!("{server}/{name}"))
        .or_else(|| public_address(&git(root, &["remote", "get-url", "origin"])?))
}

/// A remote as a web address without credentials; `None` for folders, other protocols and private forms.
fn public_address(remote: &str) -> Option<String> {
    let path = remote
        .strip_prefix("git@github.com:")
        .map(|path| format!("github.com/{path}"))
        .or_else(|| remote.strip_prefix("https://").map(str::to_owned))?;
    let path = path.trim_end_matches('/');
    let path = path.strip_suffix(".git").unwrap_or(path);
    let plain = path.contains('/') && !path.contains('@') && !path.contains(char::is_whitespace);
    plain.then(|| format!("https://{path}"))
}

/// Address of the run in continuous integration, as GitHub states it.
fn link() -> Option<String> {
    let part = |name: &str| std::env::var(name).ok();
    Some(format!(
        "{}/{}/actions/runs/{}",
        part("GITHUB_SERVER_URL")?,
        part("GITHUB_REPOSITORY")?,
        part("GITHUB_RUN_ID")?
    ))
}

/// Seconds since 1970 as `YYYY-MM-DDThh:mm:ssZ` (Gregorian calendar; days counted from 1 March of year 0).
fn iso_8601(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    let day_of_era_0 = days + 719_468;
    let era = day_of_era_0 / 146_097;
    let day = day_of_era_0 % 146_097;
    let year_of_era = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day_of_year = day - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day_of_month = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 {
        month_from_march + 3
    } else {
        month_from_march - 9
    };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!(
        "{year:04}-{month:02}-{day_of_month:02}T{:02}:{:02}:{:02}Z",
        rest / 3600,
        rest % 3600 / 60,
        rest % 60
    )
}

#[cfg(test)]
mod tests {
    use super::{iso_8601, public_address};

    #[test]
    fn only_public_addresses_are_linked_to() {
        let found = Some("https://github.com/someone/bristle".to_owned());
        for remote in [
            "https://github.com/someone/bristle",
            "https://github.com/someone/bristle.git",
            "git@github.com:someone/bristle.git",
        ] {
            assert_eq!(public_address(remote), found, "{remote}");
        }
        for remote in [
            "/srv/bristle",
            "https://token@github.com/someone/bristle",
            "https://nowhere",
            "ssh://git@host/bristle",
        ] {
            assert_eq!(public_address(remote), None, "{remote}");
        }
    }

    #[test]
    fn the_calendar_is_right_at_leap_days_and_turns_of_year() {
        assert_eq!(iso_8601(0), "1970-01-01T00:00:00Z");
        assert_eq!(iso_8601(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(iso_8601(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(iso_8601(1_735_689_599), "2024-12-31T23:59:59Z");
        assert_eq!(iso_8601(1_735_689_600), "2025-01-01T00:00:00Z");
    }
}
