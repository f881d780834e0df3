//! The bus inside one process: a hub that calls subscribers on the publisher's thread.

use super::bus::{AliveSink, Bus, BusError, Class, Replies, Request, Sink, matches};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

type Handler = Arc<dyn Fn(Request) + Send + Sync>;

#[derive(Default)]
struct Declared {
    sinks: Vec<(u64, String, Arc<Sink>)>,
    handlers: Vec<(u64, String, Handler)>,
    alive: Vec<(u64, String)>,
    watchers: Vec<(u64, String, Arc<AliveSink>)>,
    next_member: u64,
}

/// Where all local members meet.
#[derive(Clone, Default)]
pub struct LocalHub(Arc<Mutex<Declared>>);

impl LocalHub {
    /// A new member of the hub.
    #[must_use]
    pub fn join(&self) -> LocalBus {
        let mut declared = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        declared.next_member += 1;
        LocalBus { hub: self.clone(), member: declared.next_member }
    }
}

/// One member's end of a [`LocalHub`].
pub struct LocalBus {
    hub: LocalHub,
    member: u64,
}

impl LocalBus {
    fn declared<R>(&self, use_it: impl FnOnce(&mut Declared) -> R) -> R {
        use_it(&mut self.hub.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn tell_watchers(&self, key: &str, alive: bool) {
        let watchers: Vec<_> = self.declared(|d| {
            d.watchers
                .iter()
                .filter(|(_, pattern, _)| matches(pattern, key))
                .map(|(_, _, sink)| Arc::clone(sink))
                .collect()
        });
        for watcher in watchers {
            watcher(key, alive);
        }
    }
}

impl Bus for LocalBus {
    fn publish(&self, key: &str, _class: Class, body: Vec<u8>) -> Result<(), BusError> {
        let sinks: Vec<_> = self.declared(|d| {
            d.sinks
                .iter()
                .filter(|(_, pattern, _)| matches(pattern, key))
                .map(|(_, _, sink)| Arc::clone(sink))
                .collect()
        });
        for sink in sinks {
            sink(key, &body);
        }
        Ok(())
    }

    fn subscribe(&self, pattern: &str, sink: Sink) -> Result<(), BusError> {
        self.declared(|d| d.sinks.push((self.member, pattern.to_owned(), Arc::new(sink))));
        Ok(())
    }

    fn serve(
        &self,
        key: &str,
        handler: Box<dyn Fn(Request) + Send + Sync>,
    ) -> Result<(), BusError> {
        self.declared(|d| d.handlers.push((self.member, key.to_owned(), Arc::from(handler))));
        Ok(())
    }

    fn request(
        &self,
        key: &str,
        body: Vec<u8>,
        _deadline: Duration,
        replies: Replies,
    ) -> Result<(), BusError> {
        let handlers: Vec<_> = self.declared(|d| {
            d.handlers
                .iter()
                .filter(|(_, served, _)| served == key)
                .map(|(_, _, handler)| Arc::clone(handler))
                .collect()
        });
        // The last owner of `end` tells that no more answers will come, answered or not.
        let end = Arc::new(End(Mutex::new(replies)));
        for handler in handlers {
            let end = Arc::clone(&end);
            handler(Request::new(body.clone(), move |reply| end.tell(Some(reply))));
        }
        Ok(())
    }

    fn announce(&self, key: &str) -> Result<(), BusError> {
        self.declared(|d| d.alive.push((self.member, key.to_owned())));
        self.tell_watchers(key, true);
        Ok(())
    }

    fn watch(&self, pattern: &str, sink: AliveSink) -> Result<(), BusError> {
        let sink = Arc::new(sink);
        let alive: Vec<String> = self.declared(|d| {
            d.watchers.push((self.member, pattern.to_owned(), Arc::clone(&sink)));
            d.alive.iter().filter(|(_, k)| matches(pattern, k)).map(|(_, k)| k.clone()).collect()
        });
        for key in alive {
            sink(&key, true);
        }
        Ok(())
    }

    fn close(&self) {
        let gone: Vec<String> = self.declared(|d| {
            let own = self.member;
            d.sinks.retain(|(member, ..)| *member != own);
            d.handlers.retain(|(member, ..)| *member != own);
            d.watchers.retain(|(member, ..)| *member != own);
            let gone = d.alive.iter().filter(|(m, _)| *m == own).map(|(_, k)| k.clone()).collect();
            d.alive.retain(|(member, _)| *member != own);
            gone
        });
        for key in gone {
            self.tell_watchers(&key, false);
        }
    }
}

struct End(Mutex<Replies>);

impl End {
    fn tell(&self, reply: Option<Vec<u8>>) {
        (self.0.lock().unwrap_or_else(PoisonError::into_inner))(reply);
    }
}

impl Drop for End {
    fn drop(&mut self) {
        self.tell(None);
    }
}
