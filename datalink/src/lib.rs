//! DIS over UDP.
