"""Small OpenDRIVE documents as other tools write them: a road or two, with one thing that is unusual or wrong."""

from __future__ import annotations

SCHEMA = "http://code.asam.net/simulation/standard/opendrive_schema"
DECLARATION = '<?xml version="1.0" encoding="UTF-8"?>'
LINE = "<line/>"
WIDTH = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>'


def lane(number: int, *, kind: str = "driving", to: str = "", width: str = WIDTH) -> str:
    """A lane; `to` is its successor."""
    link = f'<successor id="{to}"/>' if to else ""
    return f'<lane id="{number}" type="{kind}" level="false"><link>{link}</link>{width}</lane>'


def section(s: float = 0.0, left: str = "", right: str = "", center: str = '<lane id="0" type="none"/>') -> str:
    """A lane section."""
    return (
        f'<laneSection s="{s:g}"><left>{left}</left><center>{center}</center><right>{right or lane(-1)}</right>'
        "</laneSection>"
    )


def road(
    number: str = "1",
    *,
    x: float = 0.0,
    y: float = 0.0,
    junction: str = "-1",
    to: str = "",
    plan: str | None = None,
    profile: str = "",
    lanes: str | None = None,
    signals: str = "",
    length: float = 200.0,
) -> str:
    """A straight road of 200 m along +x with a lane each way; `to` is the `elementId` of the road that follows."""
    link = f'<successor elementType="road" elementId="{to}" contactPoint="start"/>' if to else ""
    shape = f'<geometry s="0" x="{x}" y="{y}" hdg="0" length="{length}"><line/></geometry>' if plan is None else plan
    inside = section(left=lane(1)) if lanes is None else lanes
    return (
        f'<road name="" length="{length}" id="{number}" junction="{junction}"><link>{link}</link>'
        f"<planView>{shape}</planView><elevationProfile>{profile}</elevationProfile><lanes>{inside}</lanes>"
        f"<signals>{signals}</signals></road>"
    )


def document(
    body: str | None = None,
    *,
    declaration: str = DECLARATION,
    attributes: str = "",
    revision: int = 4,
    reference: str = "+proj=tmerc +lat_0=0 +lon_0=0",
    header: str = "",
) -> str:
    """A document; by default with one road."""
    return (
        f'{declaration}<OpenDRIVE{attributes}><header revMajor="1" revMinor="{revision}" name="" version="1.0">'
        f"<geoReference><![CDATA[{reference}]]></geoReference>{header}</header>{road() if body is None else body}"
        "</OpenDRIVE>"
    )


def light(number: str) -> str:
    """A traffic light."""
    return f'<signal s="20" t="-5" id="{number}" name="" dynamic="yes" orientation="+" type="1000001" subtype="-1"/>'


def connection(into: str, *, key: str = "connectingRoad", number: str = "10", kind: str = "default") -> str:
    """A junction with one connection."""
    return (
        f'<junction id="{number}" name="" type="{kind}"><connection id="0" incomingRoad="1" {key}="{into}" '
        'contactPoint="start"><laneLink from="-1" to="-1"/></connection></junction>'
    )


def with_prefix(text: str) -> str:
    """The same document with a prefix before each element."""
    head, _, body = text.partition("<OpenDRIVE")
    body = f"<OpenDRIVE{body}".replace("</", "\0").replace("<!", "\1")
    body = body.replace("<", "<od:").replace("\0", "</od:").replace("\1", "<!")
    return head + body.replace("<od:OpenDRIVE", f'<od:OpenDRIVE xmlns:od="{SCHEMA}"')
