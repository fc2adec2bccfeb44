//! The document of a reproduction: figures, tables and the page; reads results, computes nothing.
