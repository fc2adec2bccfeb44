//! Tests that drive the program as a user does; see the test files beside this package.
