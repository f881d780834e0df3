//! A stack for each of many keys, all in one memory.

/// Stacks of `T` by number.
#[derive(Clone, Debug)]
pub(super) struct Stacks<T> {
    top: Vec<u32>,
    /// What was put, and what lies under it.
    all: Vec<(T, u32)>,
}

/// Nothing lies there.
const NONE: u32 = u32::MAX;

impl<T> Stacks<T> {
    /// So many empty ones.
    pub(super) fn new(count: usize) -> Self {
        Self { top: vec![NONE; count], all: Vec::new() }
    }

    pub(super) fn put(&mut self, on: usize, what: T) {
        let under = std::mem::replace(&mut self.top[on], self.all.len() as u32);
        self.all.push((what, under));
    }

    /// What lies on one of them, what was put last first.
    pub(super) fn of(&self, on: usize) -> impl Iterator<Item = &T> {
        let mut next = self.top[on];
        std::iter::from_fn(move || {
            let (what, under) = self.all.get(next as usize)?;
            next = *under;
            Some(what)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_last_comes_first() {
        let mut stacks = Stacks::new(3);
        for (on, what) in [(0, 'a'), (2, 'b'), (0, 'c'), (2, 'd'), (0, 'e')] {
            stacks.put(on, what);
        }
        let of = |on| stacks.of(on).collect::<String>();
        assert_eq!([of(0), of(1), of(2)], ["eca", "", "db"]);
    }
}
