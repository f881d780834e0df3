//! Who may say and ask what on the synchronisation plane, by the name in its certificate. One list for all: the
//! same is enforced at every end, and what stands in no line is refused.

use serde_json::{Value, json};

/// What a holder of a certificate may do. `{n}` stands for its own name.
struct Role {
    /// Names of certificates.
    names: &'static [&'static str],
    /// Keys that it publishes.
    says: &'static [&'static str],
    /// Keys that it serves.
    serves: &'static [&'static str],
    /// Keys that it hears.
    hears: &'static [&'static str],
    /// Keys that it asks.
    asks: &'static [&'static str],
}

/// What every essential member may do.
const MEMBER_SAYS: [&str; 3] = ["fed/{n}", "beat/{n}", "obs/fed/{n}"];
const MEMBER_SERVES: [&str; 4] = ["frames/{n}", "frames/{n}/**", "log/{n}", "candidate/{n}"];
const MEMBER_HEARS: [&str; 4] = ["ctl/order", "ctl/beat", "fed/*", "beat/*"];
const MEMBER_ASKS: [&str; 4] = ["ctl/join", "ctl/log", "frames/**", "log/*"];

/// Who passes on what others say. It holds the list against them; at their ends nobody but it is seen.
const ROUTER: &str = "router";

/// Names that a certificate of a spectator stands for: its own, and that with a number.
const SPECTATOR: &str = "{n}$*";

const ROLES: [Role; 12] = [
    Role {
        names: &["admin-station", "admin-station-standby"],
        says: &["ctl/order", "ctl/beat", "ctl/lead", "obs/**"],
        serves: &["ctl/**", "log/run", "log/conductor", "frames/conductor", "obs/**"],
        hears: &["fed/*", "beat/*", "obs/**", "tracks/**", "ctl/order", "ctl/beat", "ctl/lead"],
        asks: &["log/*", "frames/*", "candidate/*", "agent/*", "ctl/**"],
    },
    Role {
        names: &["traffic-generator"],
        says: &["obs/traffic", "obs/measures", "obs/driven", "obs/inputs"],
        serves: &["obs/traffic/**", "obs/driven/**"],
        hears: &[],
        asks: &[],
    },
    Role {
        names: &["external-world"],
        says: &["obs/weather", "obs/flights"],
        serves: &["obs/weather/**", "obs/flights/**", "flights/**"],
        hears: &[],
        asks: &[],
    },
    Role {
        names: &["smdfm"],
        says: &["tracks/**"],
        serves: &["tracks/**"],
        hears: &["control/**"],
        asks: &["flights/**"],
    },
    Role {
        names: &["control"],
        says: &["control/**"],
        serves: &["control/**"],
        hears: &["tracks/**"],
        asks: &["tracks/**", "flights/**"],
    },
    Role {
        names: &["visitors"],
        says: &[],
        serves: &["seat/*/say", "visitors/*/handover"],
        hears: &["control/**", "tracks/**"],
        asks: &["flights/**"],
    },
    Role {
        names: &["viewer-logger"],
        says: &["fed/{n}$*", "beat/{n}$*", "obs/fed/{n}$*"],
        serves: &[],
        hears: &["obs/**", "tracks/**", "control/**"],
        asks: &[
            "ctl/join",
            "ctl/command",
            "ctl/statistics",
            "obs/**",
            "tracks/**",
            "control/**",
            "flights/**",
            "log/run",
            "seat/*/say",
        ],
    },
    Role {
        names: &["gateway"],
        says: &["fed/{n}$*", "beat/{n}$*", "obs/fed/{n}$*", "obs/foreign"],
        serves: &[],
        hears: &["obs/**", "tracks/**", "control/**"],
        asks: &[
            "ctl/join",
            "obs/**",
            "tracks/**",
            "control/**",
            "flights/**",
            "visitors/*/handover",
        ],
    },
    Role {
        names: &["operator"],
        says: &[],
        serves: &[],
        hears: &[],
        asks: &["ctl/command", "ctl/statistics", "seat/*/say", "visitors/*/handover"],
    },
    Role { names: &[ROUTER], says: &[], serves: &[], hears: &[], asks: &[] },
    Role { names: &["agent"], says: &[], serves: &["agent/*"], hears: &[], asks: &[] },
    Role {
        names: &["recorder"],
        says: &["fed/{n}$*", "beat/{n}$*", "obs/fed/{n}$*"],
        serves: &[],
        hears: &["obs/**", "tracks/**", "control/**"],
        asks: &["ctl/join", "ctl/log", "log/*", "obs/**", "tracks/**", "flights/**"],
    },
];

/// Essential members, which all may do what a member does.
const MEMBERS: [&str; 5] = ["traffic-generator", "external-world", "smdfm", "control", "visitors"];

/// What an SMDFM may beside a member's own that has some of the sensors and tells their plots to the first: nothing.
const FRONT_END: Role =
    Role { names: &["smdfm"], says: &[], serves: &[], hears: &[], asks: &["flights/**"] };

/// Most traffic generators of one federation, and most SMDFMs, of which the first has no number.
const GENERATORS: u32 = 16;
const SMDFMS: u32 = 8;

/// Every name that a certificate may have, with so many traffic generators and SMDFMs.
#[must_use]
pub fn names(generators: u32, smdfms: u32) -> Vec<String> {
    let mut names: Vec<String> =
        ROLES.iter().flat_map(|role| role.names).map(|name| (*name).to_owned()).collect();
    if generators > 1 {
        names.extend((1..=generators).map(|n| format!("traffic-generator-{n}")));
    }
    names.extend((2..=smdfms).map(|n| format!("smdfm-{n}")));
    names
}

/// The configuration `access_control` of the synchronisation library, for exercise `exercise`.
#[must_use]
pub fn access_control(exercise: u8) -> Value {
    let (mut rules, mut subjects, mut policies) = (Vec::new(), Vec::new(), Vec::new());
    for role in &ROLES {
        for base in role.names {
            let (numbers, numbered) = match *base {
                "traffic-generator" => (Some(1..=GENERATORS), role),
                "smdfm" => (Some(2..=SMDFMS), &FRONT_END),
                _ => (None, role),
            };
            let numbered = numbers.into_iter().flatten().map(|n| (format!("{base}-{n}"), numbered));
            for (name, role) in std::iter::once(((*base).to_owned(), role)).chain(numbered) {
                let own = rules_of(role, base, &name, exercise);
                let ids: Vec<Value> = own.iter().map(|rule| rule["id"].clone()).collect();
                rules.extend(own);
                subjects.push(json!({ "id": name, "cert_common_names": [name] }));
                policies.push(json!({ "rules": ids, "subjects": [name] }));
            }
        }
    }
    json!({
        "enabled": true,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    })
}

/// Kinds of messages that the list knows.
const EVERYTHING: [&str; 9] = [
    "put",
    "delete",
    "query",
    "reply",
    "declare_subscriber",
    "declare_queryable",
    "liveliness_token",
    "declare_liveliness_subscriber",
    "liveliness_query",
];

/// What may come from `name` (ingress) and go to it (egress).
fn rules_of(role: &Role, base: &str, name: &str, exercise: u8) -> Vec<Value> {
    let member = MEMBERS.contains(&base);
    let keys = |common: &[&str], own: &[&str]| -> Vec<String> {
        let common = if member { common } else { &[] };
        let all = common.iter().chain(own);
        all.map(|key| format!("seeds/{exercise}/{}", key.replace("{n}", name))).collect()
    };
    let says = keys(&MEMBER_SAYS, role.says);
    let serves = keys(&MEMBER_SERVES, role.serves);
    let hears = keys(&MEMBER_HEARS, role.hears);
    let asks = keys(&MEMBER_ASKS, role.asks);
    let everything = vec![format!("seeds/{exercise}/**")];
    let alive = vec![format!("seeds/{exercise}/alive/**")];
    // A spectator may be one of several, each with a number after the name.
    let own_alive = match says.iter().any(|key| key.ends_with("$*")) {
        true => SPECTATOR.replace("{n}", name),
        false => name.to_owned(),
    };
    let own_alive = vec![format!("seeds/{exercise}/alive/{own_alive}/*")];
    let liveliness = ["declare_liveliness_subscriber", "liveliness_query"];
    let mut rules = Vec::new();
    let mut rule = |what: &str, flow: &str, messages: &[&str], keys: &[String]| {
        if !keys.is_empty() {
            rules.push(json!({
                "id": format!("{name} {what}"), "permission": "allow",
                "messages": messages, "flows": [flow], "key_exprs": keys,
            }));
        }
    };
    if name == ROUTER {
        rule("passes on", "ingress", &EVERYTHING, &everything);
        rule("is told", "egress", &EVERYTHING, &everything);
    }
    rule("says", "ingress", &["put"], &says);
    rule("is alive", "ingress", &["liveliness_token"], &own_alive);
    rule("listens", "ingress", &["declare_subscriber"], &hears);
    rule("serves", "ingress", &["declare_queryable", "reply"], &serves);
    rule("asks", "ingress", &["query"], &asks);
    rule("watches", "ingress", &liveliness, &alive);
    rule("hears", "egress", &["put"], &hears);
    rule("is asked", "egress", &["query"], &serves);
    rule("is answered", "egress", &["reply"], &asks);
    rule(
        "is told who is there",
        "egress",
        &["declare_subscriber", "declare_queryable"],
        &everything,
    );
    rule(
        "is told who is alive",
        "egress",
        &["liveliness_token", liveliness[0], liveliness[1]],
        &alive,
    );
    rules
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names that may `message` on a key, coming in.
    fn who(list: &Value, message: &str, key: &str) -> Vec<String> {
        let key: zenoh::key_expr::KeyExpr<'static> = key.to_owned().try_into().expect("a key");
        let allows = |rule: &Value| {
            let has = |field: &str, word: &str| {
                rule[field].as_array().is_some_and(|list| list.iter().any(|m| m == word))
            };
            let keys = rule["key_exprs"].as_array().expect("keys").iter();
            let mut keys = keys.filter_map(Value::as_str).map(|k| {
                zenoh::key_expr::KeyExpr::try_from(k.to_owned()).unwrap_or_else(|e| panic!("{e}"))
            });
            has("messages", message) && has("flows", "ingress") && keys.any(|k| k.includes(&key))
        };
        let rules = list["rules"].as_array().expect("rules");
        let ids: Vec<&Value> = rules.iter().filter(|r| allows(r)).map(|r| &r["id"]).collect();
        let policies = list["policies"].as_array().expect("policies").iter();
        let mut names: Vec<String> = policies
            .filter(|p| p["rules"].as_array().expect("ids").iter().any(|id| ids.contains(&id)))
            .filter_map(|p| p["subjects"][0].as_str().map(str::to_owned))
            .collect();
        names.sort();
        // A router passes on whatever it let in, of this exercise only.
        let ours = key.as_str().starts_with("seeds/1/") || key.as_str().starts_with("seeds/7/");
        assert_eq!(names.iter().any(|name| name == ROUTER), ours, "{key}");
        names.retain(|name| name != ROUTER);
        names
    }

    #[test]
    fn orders_come_from_the_station_and_reports_from_their_own_member() {
        let list = access_control(7);
        let station = ["admin-station", "admin-station-standby"];
        for key in ["ctl/order", "ctl/beat", "obs/state", "obs/operation"] {
            assert_eq!(who(&list, "put", &format!("seeds/7/{key}")), station, "{key}");
        }
        for name in names(3, 3).into_iter().filter(|name| name != ROUTER) {
            for key in ["fed", "beat"].map(|kind| format!("seeds/7/{kind}/{name}")) {
                let allowed = who(&list, "put", &key);
                let says = !["admin-station", "admin-station-standby", "operator", "agent"]
                    .contains(&name.as_str());
                assert_eq!(allowed == [name.clone()], says, "{key}: {allowed:?}");
            }
            let key = format!("seeds/7/alive/{name}/3");
            assert!(who(&list, "liveliness_token", &key).iter().eq([&name]), "{key}");
        }
        assert_eq!(who(&list, "put", "seeds/7/fed/viewer-logger-2"), ["viewer-logger"]);
        assert_eq!(who(&list, "put", "seeds/7/tracks/1/scan"), ["smdfm"]);
        assert_eq!(
            who(&list, "query", "seeds/7/ctl/command"),
            ["admin-station", "admin-station-standby", "operator", "viewer-logger"]
        );
        // Lights and alerts of before, by whoever joins late.
        for key in ["control/1/lights/last", "control/1/alerts/last"] {
            let key = format!("seeds/7/{key}");
            assert_eq!(who(&list, "query", &key), ["gateway", "viewer-logger"], "{key}");
            assert_eq!(who(&list, "reply", &key), ["control"], "{key}");
        }
        let station = who(&list, "query", "seeds/7/agent/do");
        assert_eq!(station, ["admin-station", "admin-station-standby"], "who starts processes");
        assert_eq!(who(&list, "reply", "seeds/7/agent/do"), ["agent"]);
        for key in ["seeds/8/ctl/order", "seeds/7/unknown", "other"] {
            assert!(who(&list, "put", key).is_empty(), "{key}");
        }
    }

    #[test]
    fn spectators_hear_only_what_may_be_lost() {
        let list = access_control(1);
        for key in ["ctl/order", "fed/smdfm", "fed/*", "frames/smdfm"] {
            let allowed = who(&list, "declare_subscriber", &format!("seeds/1/{key}"));
            for spectator in ["viewer-logger", "gateway", "operator", "recorder"] {
                assert!(!allowed.iter().any(|n| n == spectator), "{key}: {spectator}");
            }
        }
        assert!(who(&list, "declare_subscriber", "seeds/1/**").is_empty(), "nobody hears all");
    }
}
