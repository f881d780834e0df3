//! The screen of `watch`, drawn from what it shows: a pure function, the same cells for the same values and size.
//!
//! Beside every colour stands a word or a shape. Where there is no room, what matters least is left out.

use super::keys::STEP;
use super::shown::{Row, Run, Shown};
use crate::runtime::messages::Health;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Sparkline;
use std::collections::VecDeque;

/// Draws everything.
pub(super) fn draw(frame: &mut Frame<'_>, shown: &Shown) {
    let area = frame.area();
    let room = Room::of(area, shown);
    let mut place = Place { area, at: area.y };
    for line in head(shown, area.width).into_iter().take(room.head) {
        place.line(frame, line);
    }
    if let Some(line) = silence(shown) {
        place.line(frame, line);
    }
    place.skip(room.gap);
    for line in table(shown, area.width, room.rows) {
        place.line(frame, line);
    }
    place.skip(room.gap);
    for line in alarms(shown, area.width, room.alarms) {
        place.line(frame, line);
    }
    if room.curves > 0 {
        place.skip(room.gap);
        curves(frame, &mut place, shown);
    }
    let keys = area.bottom().saturating_sub(1);
    let mut foot = Place { area, at: keys.saturating_sub(room.notice).max(area.y) };
    if room.notice > 0 {
        foot.line(frame, notice(shown));
    }
    if room.keys > 0 {
        foot.line(frame, key_line(area.width));
    }
}

/// Lines for each part.
#[derive(Debug, Default)]
struct Room {
    head: usize,
    rows: usize,
    alarms: usize,
    curves: usize,
    gap: u16,
    notice: u16,
    keys: u16,
}

/// Curves, one line each.
const CURVES: usize = 3;

impl Room {
    /// What matters goes first: head, keys, what was said; some alarms; federates; curves; the rest of the alarms; gaps.
    fn of(area: Rect, shown: &Shown) -> Self {
        let mut left = usize::from(area.height);
        let mut take = |most: usize| {
            let taken = most.min(left);
            left -= taken;
            taken
        };
        let head = take(1);
        take(usize::from(shown.silent_s.is_some()));
        let keys = take(1);
        let notice = take(1);
        let head = head + take(1);
        let wanted = alarms(shown, area.width, usize::MAX).len();
        let few = take(wanted.min(if area.height < 16 { 2 } else { 4 }));
        let rows = take(shown.rows.len() + 1);
        let curves = if take(CURVES) == CURVES { CURVES } else { 0 };
        let more = take(wanted - few);
        let gaps = 2 + usize::from(curves > 0);
        let gap = u16::from(take(gaps) == gaps);
        let (keys, notice) = (u16::from(keys > 0), u16::from(notice > 0));
        Self { head, rows, alarms: few + more, curves, gap, notice, keys }
    }
}

/// Where the next line goes.
struct Place {
    area: Rect,
    at: u16,
}

impl Place {
    fn line(&mut self, frame: &mut Frame<'_>, line: Line<'_>) {
        if let Some(row) = self.row() {
            frame.render_widget(line, row);
        }
    }

    /// A row of the screen, if one is left.
    fn row(&mut self) -> Option<Rect> {
        let row = Rect { y: self.at, height: 1, ..self.area };
        let free = self.at < self.area.bottom();
        self.at = self.at.saturating_add(1);
        free.then_some(row)
    }

    fn skip(&mut self, lines: u16) {
        self.at = self.at.saturating_add(lines);
    }
}

fn plain() -> Style {
    Style::new()
}

fn bold() -> Style {
    Style::new().add_modifier(Modifier::BOLD)
}

fn coloured(color: Color) -> Style {
    Style::new().fg(color)
}

/// Parts with two spaces between, as many from the first on as fit.
fn joined<'a>(parts: Vec<Span<'a>>, width: u16) -> Line<'a> {
    let mut spans: Vec<Span<'a>> = Vec::new();
    let mut used = 1;
    for part in parts {
        let gap = if spans.is_empty() { " " } else { "  " };
        used += part.width() + if spans.is_empty() { 0 } else { 2 };
        if used > usize::from(width) && !spans.is_empty() {
            break;
        }
        spans.push(Span::raw(gap));
        spans.push(part);
    }
    Line::from(spans)
}

fn head(shown: &Shown, width: u16) -> Vec<Line<'_>> {
    let run = &shown.run;
    let (mark, color) = match &run.phase[..] {
        "RUNNING" => ("►", Color::Green),
        "FROZEN" => ("‖", Color::Cyan),
        "STOPPED" => ("■", Color::Yellow),
        _ => ("○", Color::Yellow),
    };
    let time = |frame: u64| frame as f64 * run.step_s;
    let first = vec![
        Span::styled(format!("{mark} {}", run.phase), coloured(color).add_modifier(Modifier::BOLD)),
        Span::raw(format!("{:.1} s of {:.1} s", time(run.frame), time(run.last_frame))),
        Span::raw(format!("frame {} of {}", run.frame, run.last_frame)),
        Span::raw(format!("run {}", run.run)),
    ];
    let second = vec![
        Span::raw(rates(run)),
        Span::raw(&shown.endpoint[..]),
        Span::raw(shortened(&run.scene, 24)),
    ];
    vec![joined(first, width), joined(second, width)]
}

fn rates(run: &Run) -> String {
    let asked = run.rate.map_or_else(|| "fast".to_owned(), |rate| format!("{rate}x"));
    format!("rate {asked}, reached {:.1}x", run.reached)
}

fn silence(shown: &Shown) -> Option<Line<'_>> {
    let silent_s = shown.silent_s?;
    let words = format!(" ! no answer from the station for {silent_s} s; trying again");
    Some(Line::styled(words, coloured(Color::Red).add_modifier(Modifier::REVERSED)))
}

/// A column: its word, its width, what stands in it.
type Column = (&'static str, usize, fn(&Row) -> Span<'static>);

/// In the order in which they are left out, the last first.
const COLUMNS: [Column; 8] = [
    ("federate", 22, |row| Span::raw(format!(" {:<21}", shortened(&row.name, 20)))),
    ("health", 12, |row| health(row.health)),
    ("heard ms", 9, |row| cell(9, row.heard_ms)),
    ("queue", 7, |row| cell(7, row.queue)),
    ("clock s", 8, |row| cell(8, row.clock_s.map(apart))),
    ("CPU %", 7, |row| cell(7, row.cpu_pct.map(|cpu| format!("{cpu:.1}")))),
    ("MB", 7, |row| cell(7, row.memory_mb.map(|mb| format!("{mb:.0}")))),
    ("lost", 8, |row| cell(8, row.lost)),
];

/// A figure at the right of its column; a dash where it is not known.
fn cell(width: usize, figure: Option<impl std::fmt::Display>) -> Span<'static> {
    let text = figure.map_or_else(|| "-".to_owned(), |figure| figure.to_string());
    Span::raw(format!("{text:>width$}"))
}

fn apart(ahead_s: f64) -> String {
    if ahead_s.abs() < 100.0 { format!("{ahead_s:+.2}") } else { format!("{ahead_s:+.0}") }
}

/// Who needs a person most comes first, where not all have room.
fn urgency(row: &Row) -> usize {
    let order = [Health::Lost, Health::Silent, Health::Late, Health::Returning];
    order.iter().position(|health| Some(*health) == row.health).unwrap_or(order.len())
}

fn health(health: Option<Health>) -> Span<'static> {
    let Some(health) = health else { return Span::raw("  station   ") };
    let (mark, style) = match health {
        Health::Alive => ("●", coloured(Color::Green)),
        Health::Late => ("◐", coloured(Color::Yellow)),
        Health::Silent => ("○", coloured(Color::Yellow)),
        Health::Lost => ("x", coloured(Color::Red).add_modifier(Modifier::BOLD)),
        Health::Returning => ("»", coloured(Color::Cyan)),
    };
    Span::styled(format!("{mark} {:<10}", health.word()), style)
}

/// The head of the table and the rows that fit, from the one that the arrows chose; where not all fit, who needs a person is first.
fn table(shown: &Shown, width: u16, lines: usize) -> Vec<Line<'static>> {
    if lines == 0 {
        return Vec::new();
    }
    let mut columns: Vec<&Column> = Vec::new();
    let mut used = 0;
    for column in &COLUMNS {
        used += column.1;
        if used > usize::from(width) && !columns.is_empty() {
            break;
        }
        columns.push(column);
    }
    let (all, fit) = (shown.rows.len(), lines - 1);
    let first = shown.first.min(all.saturating_sub(fit));
    let last = (first + fit).min(all);
    let mut rows: Vec<&Row> = shown.rows.iter().collect();
    if last - first < all {
        rows.sort_by_key(|row| urgency(row));
    }
    let head = columns.iter().map(|(word, width, _)| match *word {
        "federate" if last - first < all => {
            let part = format!("{}-{last} of {all} ↑↓", first + 1);
            Span::raw(format!(" {part:<21}"))
        }
        "federate" => Span::raw(format!(" {word:<21}")),
        "health" => Span::raw(format!("  {word:<10}")),
        _ => Span::raw(format!("{word:>width$}")),
    });
    let mut table = vec![Line::from_iter(head).style(bold())];
    for row in &rows[first..last] {
        table.push(Line::from_iter(columns.iter().map(|(_, _, of)| of(row))));
    }
    table
}

/// What a person should look after, in whole words as far as `lines` go.
fn alarms(shown: &Shown, width: u16, lines: usize) -> Vec<Line<'static>> {
    if shown.alarms.is_empty() {
        let none = Line::styled(" no alarms", plain());
        return std::iter::once(none).take(lines).collect();
    }
    let red = coloured(Color::Red);
    let title =
        Line::styled(format!(" alarms: {}", shown.alarms.len()), red.add_modifier(Modifier::BOLD));
    let mut all = vec![title];
    for alarm in &shown.alarms {
        for (n, part) in
            wrapped(alarm, usize::from(width).saturating_sub(3)).into_iter().enumerate()
        {
            let mark = if n == 0 { " ! " } else { "   " };
            all.push(Line::from(vec![Span::styled(mark, red), Span::raw(part)]));
        }
    }
    if lines < all.len() {
        all.truncate(lines);
        if let Some(line) = all.last_mut() {
            line.push_span(Span::raw("…"));
            if line.width() > usize::from(width) {
                *line = Line::from(vec![Span::styled(" ! ", red), Span::raw("… more alarms")]);
            }
        }
    }
    all
}

/// Lines of at most `width` characters, broken between words where there are any.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let width = width.max(8);
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let mut word: Vec<char> = word.chars().filter(|c| !c.is_control()).collect();
        loop {
            let Some(line) = lines.last_mut() else { return lines };
            let used = line.chars().count();
            if used > 0 && used + 1 + word.len() <= width {
                line.push(' ');
                line.extend(word);
                break;
            } else if used > 0 {
                lines.push(String::new());
            } else {
                let rest = word.split_off(word.len().min(width));
                line.extend(word);
                if rest.is_empty() {
                    break;
                }
                word = rest;
                lines.push(String::new());
            }
        }
    }
    lines
}

/// The first characters of a text, with a dot for each of the two that say that there were more.
fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

fn curves(frame: &mut Frame<'_>, place: &mut Place, shown: &Shown) {
    let of = &shown.curves;
    for (word, curve) in
        [("frames/s", &of.frames_per_s), ("PDUs/s", &of.pdus_per_s), ("frames behind", &of.behind)]
    {
        let Some(row) = place.row() else { return };
        let newest = curve.back().map_or_else(|| "-".to_owned(), |value| format!("{value:.0}"));
        let label = Line::raw(format!(" {word:<14}{newest:>7} "));
        let wide = u16::try_from(label.width()).unwrap_or(u16::MAX).min(row.width);
        frame.render_widget(label, row);
        let right = Rect { x: row.x + wide, width: row.width - wide, ..row };
        let data = last_of(curve, usize::from(right.width));
        // Eight levels of a cell; what never was above eight is shown as it is.
        let most = data.iter().copied().max().unwrap_or(0).max(8);
        frame.render_widget(Sparkline::default().data(&data).max(most), right);
    }
}

/// The newest values that fit.
fn last_of(curve: &VecDeque<f64>, width: usize) -> Vec<u64> {
    let skip = curve.len().saturating_sub(width);
    curve.iter().skip(skip).map(|value| value.round() as u64).collect()
}

fn notice(shown: &Shown) -> Line<'_> {
    if shown.confirming {
        let words = " Stop the run for everybody? y: yes, any other key: no";
        return Line::styled(words, coloured(Color::Yellow).add_modifier(Modifier::REVERSED));
    }
    match (&shown.under_way, &shown.said) {
        (Some(words), _) => Line::raw(format!(" … {words}")),
        (None, Some((true, words))) => {
            Line::styled(format!(" ok: {words}"), coloured(Color::Green))
        }
        (None, Some((false, words))) => Line::styled(format!(" ! {words}"), coloured(Color::Red)),
        (None, None) => Line::default(),
    }
}

fn key_line(width: u16) -> Line<'static> {
    let step = format!("s step {STEP}");
    let long = ["f freeze", "r resume", &step, "+ - rate", "x stop", "q leave"].join("  ");
    let short = "f r freeze s step +- rate x stop q leave".to_owned();
    let words = if long.len() < usize::from(width) { format!(" {long}") } else { short };
    Line::styled(words, Style::new().add_modifier(Modifier::DIM))
}
