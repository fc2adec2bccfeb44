//! Lines to the terminal that outlive their reader: `bristle check PACKAGE | head` closes the pipe after ten lines, and what the command
//! still has to write to files is written all the same.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

/// A line to standard output.
macro_rules! say {
    () => { say!("") };
    ($($line:tt)*) => { $crate::say::line(&mut ::std::io::stdout().lock(), ::std::format_args!($($line)*)) };
}

/// A line to standard error.
macro_rules! say_aside {
    ($($line:tt)*) => { $crate::say::line(&mut ::std::io::stderr().lock(), ::std::format_args!($($line)*)) };
}

/// Writes a line; nobody reading it is no failure.
///
/// # Panics
/// Where it cannot be written for any other reason, such as a full disk.
pub(crate) fn line(out: &mut dyn Write, line: Arguments<'_>) {
    if let Err(error) = writeln!(out, "{line}") {
        assert!(
            error.kind() == ErrorKind::BrokenPipe,
            "cannot write a line: {error}"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Closed(ErrorKind);

    impl Write for Closed {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(self.0.into())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_left_is_no_failure() {
        line(&mut Closed(ErrorKind::BrokenPipe), format_args!("on"));
    }

    #[test]
    #[should_panic(expected = "cannot write a line")]
    fn a_full_disk_is() {
        line(&mut Closed(ErrorKind::StorageFull), format_args!("on"));
    }
}
