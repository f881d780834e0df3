//! From a datagram to its PDUs and back.

use crate::body::Body;
use crate::codec::{DecodeBody, EncodeBody};
use crate::enumerations::{PduType, ProtocolFamily, ProtocolVersion};
use crate::header::{HEADER_LEN, Header, PduStatus, family_of};
use crate::reader::{BodyError, DecodeError, Reader, Reason};
use crate::records::SimulationAddress;
use crate::wire::Wire;
use crate::writer::{EncodeError, Writer};
use crate::{DisTime, EntityState};

/// A PDU: header and body.
///
/// Made with [`Pdu::new`], which computes type, family, length and padding, or by decoding, which keeps
/// the header's octets so that encoding gives back what came.
#[derive(Clone, Debug, PartialEq)]
pub struct Pdu<'a> {
    header: Header,
    body: Body<'a>,
}

impl<'a> Pdu<'a> {
    /// A PDU to be sent.
    #[must_use]
    pub fn new(envelope: Envelope, body: impl Into<Body<'a>>) -> Self {
        let body = body.into();
        let header = envelope.header(body.pdu_type(), HEADER_LEN + body.body_len());
        Self { header, body }
    }

    /// The header. `length` is that of the decoded PDU; encoding computes it anew.
    #[must_use]
    #[inline]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The body.
    #[must_use]
    #[inline]
    pub fn body(&self) -> &Body<'a> {
        &self.body
    }

    /// The body, taken out.
    #[must_use]
    pub fn into_body(self) -> Body<'a> {
        self.body
    }

    /// Octets on the wire.
    #[must_use]
    pub fn encoded_len(&self) -> usize {
        HEADER_LEN + self.body.body_len()
    }

    /// Writes the PDU to the start of `out`; returns its octets.
    ///
    /// # Errors
    /// If `out` is too small, the PDU longer than 65535 octets, or a list longer than its count field
    /// can say.
    #[inline]
    pub fn encode(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        write(self.header, &self.body, out)
    }

    /// Appends the PDU to a buffer, which is unchanged on error; returns its octets.
    ///
    /// # Errors
    /// As [`Self::encode`], but for the size of the buffer.
    pub fn append(&self, out: &mut Vec<u8>) -> Result<usize, EncodeError> {
        append(self.header, &self.body, out)
    }

    /// The PDU in a buffer of its own.
    ///
    /// # Errors
    /// As [`Self::append`].
    pub fn encode_to_vec(&self) -> Result<Vec<u8>, EncodeError> {
        let mut out = Vec::with_capacity(self.encoded_len());
        self.append(&mut out)?;
        Ok(out)
    }
}

/// What a sender chooses of a header; the rest is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Envelope {
    /// Protocol version; [`ProtocolVersion::DIS7`] or [`ProtocolVersion::DIS6`].
    pub version: ProtocolVersion,
    /// Exercise.
    pub exercise_id: u8,
    /// Time past the hour of the data.
    pub timestamp: DisTime,
    /// Status bits; ignored (zero) in DIS 6.
    pub status: PduStatus,
}

impl Envelope {
    /// DIS 7, no status bits.
    #[must_use]
    pub fn new(exercise_id: u8, timestamp: DisTime) -> Self {
        Self {
            version: ProtocolVersion::DIS7,
            exercise_id,
            timestamp,
            status: PduStatus::default(),
        }
    }

    /// DIS 6.
    #[must_use]
    pub fn dis6(exercise_id: u8, timestamp: DisTime) -> Self {
        Self { version: ProtocolVersion::DIS6, ..Self::new(exercise_id, timestamp) }
    }

    #[inline]
    fn header(&self, pdu_type: PduType, length: usize) -> Header {
        let dis7 = self.version.0 >= ProtocolVersion::DIS7.0;
        Header {
            version: self.version,
            exercise_id: self.exercise_id,
            pdu_type,
            family: family_of(pdu_type),
            timestamp: self.timestamp,
            length: length.try_into().unwrap_or(u16::MAX),
            status: if dis7 { self.status } else { PduStatus::default() },
            padding: 0,
        }
    }

    /// Writes a PDU with this body to the start of `out`; returns its octets.
    ///
    /// # Errors
    /// If `out` is too small, the PDU longer than 65535 octets, or a list longer than its count field
    /// can say.
    #[inline]
    pub fn encode(&self, body: &impl EncodeBody, out: &mut [u8]) -> Result<usize, EncodeError> {
        write(self.header(body.pdu_type(), 0), body, out)
    }

    /// Appends a PDU with this body to a buffer, which is unchanged on error; returns its octets.
    /// Several in one buffer are a bundle.
    ///
    /// # Errors
    /// As [`Self::encode`], but for the size of the buffer.
    pub fn append(&self, body: &impl EncodeBody, out: &mut Vec<u8>) -> Result<usize, EncodeError> {
        append(self.header(body.pdu_type(), 0), body, out)
    }
}

#[inline]
fn write(mut header: Header, body: &impl EncodeBody, out: &mut [u8]) -> Result<usize, EncodeError> {
    let needs = HEADER_LEN + body.body_len();
    header.length = needs.try_into().map_err(|_| EncodeError::TooLong { octets: needs })?;
    let has = out.len();
    let Some(out) = out.get_mut(..needs) else {
        return Err(EncodeError::BufferTooSmall { needs, has });
    };
    let mut writer = Writer::new(out);
    writer.put(&header);
    body.encode_body(&mut writer)?;
    debug_assert_eq!(writer.written(), needs);
    Ok(needs)
}

fn append(header: Header, body: &impl EncodeBody, out: &mut Vec<u8>) -> Result<usize, EncodeError> {
    let start = out.len();
    let needs = HEADER_LEN + body.body_len();
    if needs > usize::from(u16::MAX) {
        return Err(EncodeError::TooLong { octets: needs });
    }
    out.resize(start + needs, 0);
    let result = write(header, body, &mut out[start..]);
    if result.is_err() {
        out.truncate(start);
    }
    result
}

/// One PDU of a datagram, cut out by its header's length; its body not looked at yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<'a> {
    /// Number of the PDU in its datagram, from 0.
    pub index: usize,
    /// Octets from the start of the datagram.
    pub offset: usize,
    /// The PDU's octets.
    pub octets: &'a [u8],
    /// Its header.
    pub header: Header,
}

impl<'a> Frame<'a> {
    /// Site and application of the entity that the PDU begins with: the sender, for most types.
    /// `None` for a PDU without room for it and for the types of live entities (46 to 50), which have
    /// another layout.
    #[must_use]
    #[inline]
    pub fn address(&self) -> Option<SimulationAddress> {
        if (46..=50).contains(&self.header.pdu_type.0) {
            return None;
        }
        self.octets.get(HEADER_LEN..HEADER_LEN + 4).map(Wire::get)
    }

    /// Decodes the body.
    ///
    /// # Errors
    /// If the body does not fit the length, with the offset and the field.
    #[inline(always)]
    pub fn decode(&self) -> Result<Pdu<'a>, DecodeError> {
        // Most of all traffic. Here the compiler knows the variant and need not copy a `Body`.
        if let Some(state) = self.decode_as::<EntityState<'a>>() {
            return state.map(|body| Pdu { header: self.header, body: Body::EntityState(body) });
        }
        self.decode_any()
    }

    #[inline(never)]
    fn decode_any(&self) -> Result<Pdu<'a>, DecodeError> {
        let mut reader = Reader::new(self.octets, HEADER_LEN);
        let body = Body::decode(self.header.pdu_type, &mut reader);
        match body.and_then(|body| reader.finish().map(|()| body)) {
            Ok(body) => Ok(Pdu { header: self.header, body }),
            Err(error) => Err(self.damaged(error)),
        }
    }

    /// Decodes the body as one type, without going through [`Body`]; `None` if the PDU is of another
    /// type or of a version before 5 or after 7. For a receiver that wants few types this is the
    /// quickest way:
    ///
    /// ```
    /// use pdu::{EntityState, frames};
    /// # let datagram = [0; 0];
    /// for frame in frames(&datagram).flatten() {
    ///     if let Some(Ok(state)) = frame.decode_as::<EntityState>() {
    ///         println!("{}", state.entity_id);
    ///     }
    /// }
    /// ```
    #[inline(always)]
    #[must_use]
    pub fn decode_as<T: DecodeBody<'a>>(&self) -> Option<Result<T, DecodeError>> {
        let known = (5..=7).contains(&self.header.version.0);
        if self.header.pdu_type != T::PDU_TYPE || !known {
            return None;
        }
        let mut reader = Reader::new(self.octets, HEADER_LEN);
        let body = T::decode_body(&mut reader);
        let body = body.and_then(|body| reader.finish().map(|()| body));
        Some(body.map_err(|error| self.damaged(error)))
    }

    #[cold]
    fn damaged(&self, error: BodyError) -> DecodeError {
        let BodyError { offset, field, part, reason } = error;
        let pdu_type = Some(self.header.pdu_type);
        let (index, pdu_offset) = (self.index, self.offset);
        DecodeError { index, pdu_offset, pdu_type, offset, field, part, reason }
    }
}

/// A decoded PDU with its place in the datagram.
#[derive(Clone, Debug, PartialEq)]
pub struct Received<'a> {
    /// Number of the PDU in its datagram, from 0.
    pub index: usize,
    /// Octets from the start of the datagram.
    pub offset: usize,
    /// The PDU's octets.
    pub octets: &'a [u8],
    /// The PDU.
    pub pdu: Pdu<'a>,
}

impl<'a> std::ops::Deref for Received<'a> {
    type Target = Pdu<'a>;
    fn deref(&self) -> &Pdu<'a> {
        &self.pdu
    }
}

/// Cuts a datagram into PDUs by the length of each header, without looking at bodies.
///
/// A length below 12 or beyond the datagram is an error and ends the walk, as nobody knows where the
/// next PDU begins; so are octets at the end that are too few for a header
/// ([`DecodeError::is_trailing`]). [`Frames::rest`] has the octets that were not walked.
#[must_use]
#[inline]
pub fn frames(datagram: &[u8]) -> Frames<'_> {
    Frames { datagram, offset: 0, index: 0, ended: false }
}

/// The walk over a datagram; see [`frames`].
#[derive(Clone, Debug)]
pub struct Frames<'a> {
    datagram: &'a [u8],
    offset: usize,
    index: usize,
    ended: bool,
}

impl<'a> Frames<'a> {
    /// The octets that are not walked (yet): after an error that ended the walk, those from the
    /// damaged header on.
    #[must_use]
    pub fn rest(&self) -> &'a [u8] {
        &self.datagram[self.offset..]
    }

    #[cold]
    fn stop(&mut self, header: Option<&Header>, reason: Reason) -> DecodeError {
        self.ended = true;
        DecodeError {
            index: self.index,
            pdu_offset: self.offset,
            pdu_type: header.map(|h| h.pdu_type),
            offset: if header.is_some() { 8 } else { 0 },
            field: if header.is_some() { "length" } else { "header" },
            part: None,
            reason,
        }
    }
}

impl<'a> Iterator for Frames<'a> {
    type Item = Result<Frame<'a>, DecodeError>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let rest = &self.datagram[self.offset..];
        if self.ended || rest.is_empty() {
            return None;
        }
        let Some(start) = rest.first_chunk::<HEADER_LEN>() else {
            return Some(Err(self.stop(None, Reason::Trailing { octets: rest.len() })));
        };
        let header = Header::get(start);
        let length = usize::from(header.length);
        if length < HEADER_LEN {
            let reason = Reason::LengthBelowHeader { length: header.length };
            return Some(Err(self.stop(Some(&header), reason)));
        }
        let Some(octets) = rest.get(..length) else {
            let reason = Reason::LengthBeyondDatagram { length: header.length, left: rest.len() };
            return Some(Err(self.stop(Some(&header), reason)));
        };
        let frame = Frame { index: self.index, offset: self.offset, octets, header };
        self.offset += length;
        self.index += 1;
        Some(Ok(frame))
    }
}

/// Decodes every PDU of a datagram: the sound ones, and an error for each damaged one, after which the
/// walk goes on where the damaged PDU's length allows it.
///
/// ```
/// # let datagram = [7, 1, 22, 5, 0, 0, 0, 1, 0, 32, 0, 0, 0, 1, 0, 2, 0, 3, 255, 255, 255, 255, 255,
/// #     255, 0, 0, 0, 0, 0, 0, 0, 0];
/// for received in pdu::pdus(&datagram) {
///     match received {
///         Ok(received) => println!("{:?}", received.body()),
///         Err(damaged) => eprintln!("{damaged}"),
///     }
/// }
/// ```
#[inline]
pub fn pdus(datagram: &[u8]) -> impl Iterator<Item = Result<Received<'_>, DecodeError>> {
    frames(datagram).map(|frame| {
        let frame = frame?;
        let Frame { index, offset, octets, .. } = frame;
        frame.decode().map(|pdu| Received { index, offset, octets, pdu })
    })
}

/// What a receiver wants, decided by the first 16 octets of a PDU. The default wants everything.
///
/// ```
/// use pdu::{Filter, enumerations::PduType};
/// let filter = Filter::default().exercise(3).only([PduType::ENTITY_STATE]);
/// # let datagram = [7, 1, 22, 5, 0, 0, 0, 1, 0, 32, 0, 0, 0, 1, 0, 2, 0, 3, 255, 255, 255, 255, 255,
/// #     255, 0, 0, 0, 0, 0, 0, 0, 0];
/// let wanted = pdu::frames(&datagram).flatten().filter(|frame| filter.wants(frame));
/// assert_eq!(wanted.count(), 0); // it is a comment of exercise 1
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Filter {
    exercise: Option<u8>,
    site: Option<u16>,
    application: Option<u16>,
    family: Option<ProtocolFamily>,
    types: [u64; 4],
}

impl Default for Filter {
    fn default() -> Self {
        Self { exercise: None, site: None, application: None, family: None, types: [u64::MAX; 4] }
    }
}

impl Filter {
    /// Only this exercise.
    #[must_use]
    pub fn exercise(self, exercise: u8) -> Self {
        Self { exercise: Some(exercise), ..self }
    }
    /// Only this site.
    #[must_use]
    pub fn site(self, site: u16) -> Self {
        Self { site: Some(site), ..self }
    }
    /// Only this application number.
    #[must_use]
    pub fn application(self, application: u16) -> Self {
        Self { application: Some(application), ..self }
    }
    /// Only this family.
    #[must_use]
    pub fn family(self, family: ProtocolFamily) -> Self {
        Self { family: Some(family), ..self }
    }
    /// Only these types.
    #[must_use]
    pub fn only(self, types: impl IntoIterator<Item = PduType>) -> Self {
        let mut bits = [0_u64; 4];
        for PduType(t) in types {
            bits[usize::from(t >> 6)] |= 1 << (t & 63);
        }
        Self { types: bits, ..self }
    }

    /// True if the PDU is wanted.
    #[must_use]
    #[inline]
    pub fn wants(&self, frame: &Frame<'_>) -> bool {
        let t = frame.header.pdu_type.0;
        if self.types[usize::from(t >> 6)] >> (t & 63) & 1 == 0
            || self.exercise.is_some_and(|e| e != frame.header.exercise_id)
            || self.family.is_some_and(|f| f != frame.header.family)
        {
            return false;
        }
        if self.site.is_none() && self.application.is_none() {
            return true;
        }
        frame.address().is_some_and(|a| {
            self.site.is_none_or(|s| s == a.site)
                && self.application.is_none_or(|n| n == a.application)
        })
    }
}
