//! Watching a run: a tree of stages with their times on a terminal, plain lines elsewhere. All of it goes to stderr.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// How a stage came to its output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// It ran.
    Computed,
    /// Nothing that it depends on had changed.
    Kept,
}

/// Shows progress.
#[derive(Debug)]
pub struct Watch {
    bars: Option<MultiProgress>,
    running: Mutex<BTreeMap<String, (Instant, Option<ProgressBar>)>>,
}

impl Default for Watch {
    fn default() -> Self {
        Self::new()
    }
}

impl Watch {
    /// Bars on a terminal, lines elsewhere.
    #[must_use]
    pub fn new() -> Self {
        let bars = std::io::stderr().is_terminal().then(MultiProgress::new);
        Self {
            bars,
            running: Mutex::default(),
        }
    }

    fn line(&self, text: &str) {
        match &self.bars {
            // Nobody is there to be told that the terminal went away.
            Some(bars) => drop(bars.println(text)),
            None => say_aside!("{text}"),
        }
    }

    /// A stage begins.
    pub fn start(&self, id: &str, title: &str) {
        let bar = self.bars.as_ref().map(|bars| {
            let bar = bars.add(ProgressBar::new_spinner());
            if let Ok(style) =
                ProgressStyle::with_template("  {spinner} {prefix:14} {elapsed:>4}  {msg}")
            {
                bar.set_style(style);
            }
            bar.set_prefix(id.to_owned());
            bar.set_message(title.to_owned());
            bar.enable_steady_tick(Duration::from_millis(120));
            bar
        });
        if bar.is_none() {
            self.line(&format!("  start  {id:14} {title}"));
        }
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        running.insert(id.to_owned(), (Instant::now(), bar));
    }

    /// A stage says what it is doing.
    pub fn say(&self, id: &str, text: &str) {
        let running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        match running.get(id) {
            Some((_, Some(bar))) => bar.set_message(text.to_owned()),
            _ => say_aside!("         {id:14} {text}"),
        }
    }

    /// A stage ended; returns its seconds.
    pub fn end(&self, id: &str, words: &str, source: Source) -> f64 {
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        let (started, bar) = running.remove(id).unwrap_or_else(|| (Instant::now(), None));
        drop(running);
        if let Some(bar) = bar {
            bar.finish_and_clear();
        }
        let seconds = started.elapsed().as_secs_f64();
        let kept = if source == Source::Kept {
            " (kept)"
        } else {
            ""
        };
        self.line(&format!("  {seconds:6.2} s {id:14} {words}{kept}"));
        seconds
    }
}
