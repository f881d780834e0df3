"""Writes the octets of PDUs as the Python package opendis 1.0 encodes them.

pip install opendis==1.0 && python3 make.py
"""

import io

from opendis import dis7
from opendis.DataOutputStream import DataOutputStream


def entity_id(site, application, entity):
    i = dis7.EntityID()
    i.siteID, i.applicationID, i.entityID = site, application, entity
    return i


def header(pdu):
    pdu.protocolVersion = 7
    pdu.exerciseID = 7
    pdu.timestamp = 0x12345679
    pdu.pduStatus = 0  # None by default, which it cannot encode
    pdu.padding = 0


def write(name, pdu, pdu_type, family):
    header(pdu)
    pdu.pduType, pdu.protocolFamily = pdu_type, family
    body = io.BytesIO()
    pdu.serialize(DataOutputStream(body))
    pdu.length = len(body.getvalue())
    out = io.BytesIO()
    pdu.serialize(DataOutputStream(out))
    with open(name + ".raw", "wb") as file:
        file.write(out.getvalue())
    print(name, len(out.getvalue()))


def ids(pdu):
    pdu.originatingEntityID = entity_id(1, 2, 3)
    pdu.receivingEntityID = entity_id(4, 5, 6)
    return pdu


espdu = dis7.EntityStatePdu()
espdu.entityID = entity_id(1, 2, 3)
espdu.forceId = 3
espdu.entityType.entityKind, espdu.entityType.domain, espdu.entityType.country = 1, 2, 225
espdu.entityType.category, espdu.entityType.subcategory = 57, 1
espdu.entityType.specific, espdu.entityType.extra = 2, 3
espdu.entityLinearVelocity.x, espdu.entityLinearVelocity.y, espdu.entityLinearVelocity.z = 1.5, -2.25, 3.125
espdu.entityLocation.x, espdu.entityLocation.y, espdu.entityLocation.z = 4278001.25, 643002.5, 4670003.75
espdu.entityOrientation.psi, espdu.entityOrientation.theta, espdu.entityOrientation.phi = 0.25, -0.5, 1.75
espdu.entityAppearance = 0x00400000
espdu.deadReckoningParameters.deadReckoningAlgorithm = 4
espdu.deadReckoningParameters.entityLinearAcceleration.x = -0.5
espdu.deadReckoningParameters.entityAngularVelocity.z = 0.25
espdu.marking.characterSet = 1
espdu.marking.setString("SWR 123")
espdu.capabilities = 3
write("entity_state", espdu, 1, 1)

pdu = ids(dis7.CreateEntityPdu())
pdu.requestID = 99
write("create_entity", pdu, 11, 5)
pdu = ids(dis7.RemoveEntityPdu())
pdu.requestID = 98
write("remove_entity", pdu, 12, 5)

pdu = ids(dis7.StartResumePdu())
pdu.requestID = 97
pdu.realWorldTime.hour, pdu.realWorldTime.timePastHour = 494000, 1001
pdu.simulationTime.hour, pdu.simulationTime.timePastHour = 494001, 1003
write("start_resume", pdu, 13, 5)

pdu = ids(dis7.StopFreezePdu())
pdu.requestID = 96
pdu.realWorldTime.hour, pdu.realWorldTime.timePastHour = 494000, 1001
pdu.reason, pdu.frozenBehavior = 2, 1
write("stop_freeze", pdu, 14, 5)

pdu = ids(dis7.AcknowledgePdu())
pdu.acknowledgeFlag, pdu.responseFlag, pdu.requestID = 3, 1, 95
write("acknowledge", pdu, 15, 5)

pdu = dis7.CollisionPdu()
pdu.issuingEntityID, pdu.collidingEntityID = entity_id(1, 2, 3), entity_id(4, 5, 6)
pdu.collisionType, pdu.mass = 1, 78000.0
pdu.velocity.x, pdu.location.z = 1.5, -2.5
write("collision", pdu, 4, 1)

pdu = dis7.DesignatorPdu()
pdu.designatingEntityID, pdu.designatedEntityID = entity_id(1, 2, 3), entity_id(4, 5, 6)
pdu.codeName, pdu.designatorCode, pdu.designatorPower, pdu.designatorWavelength = 1000, 1688, 50.0, 1.0625
pdu.designatorSpotLocation.x = 4278001.25
write("designator", pdu, 24, 6)

pdu = dis7.IsPartOfPdu()
pdu.orginatingEntityID, pdu.receivingEntityID = entity_id(1, 2, 3), entity_id(4, 5, 6)
pdu.partLocation.x = 1.5
pdu.partEntityType.entityKind = 1
write("is_part_of", pdu, 36, 7)
