//! Cache of the values made last. In go a key and a function that makes its value, out comes the value.
//! Invariant: the lock is free while a value is made, as making it may need another value of the cache.

use std::sync::{Mutex, PoisonError};

/// Values by their keys; a clone is empty.
#[derive(Debug)]
pub struct Recent<K, V>(Mutex<Vec<(K, V)>>);

impl<K, V> Default for Recent<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K, V> Clone for Recent<K, V> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<K: PartialEq, V: Clone> Recent<K, V> {
    /// Returns the value of a key, made if there is none. With more than `most` values the least recently
    /// used is dropped.
    pub fn of(&self, key: K, most: usize, make: impl FnOnce() -> V) -> V {
        let all = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = || {
            let mut all = all();
            let at = all.iter().position(|(known, _)| *known == key)?;
            all[at..].rotate_left(1);
            all.last().map(|(_, value)| value.clone())
        };
        known().unwrap_or_else(|| {
            let value = make();
            let mut all = all();
            if all.len() == most {
                all.remove(0);
            }
            all.push((key, value.clone()));
            value
        })
    }
}
