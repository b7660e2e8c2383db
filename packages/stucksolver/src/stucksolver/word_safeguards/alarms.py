"""Recognizes calls to stop and alarms. They only ever hold the vehicle, so it is also held in case of doubt.

An alarm is a call to stop or brake ("Hit the brakes!"), a predicted collision ("You're going to hit him!"), a shout of
warning ("Look out!", "A kid!"), or a person or animal in the path ("There's a child running after the ball"). An
utterance is no alarm if it denies the danger ("you won't hit anything"), requests the opposite ("don't stop here") or
is about another day.
"""

from __future__ import annotations

import re

from stucksolver.word_safeguards.clauses import Clause, any_of, clauses_of, is_of_another_time, plain
from stucksolver.word_safeguards.living_beings import (
    ALIVE,
    COMES_BACK,
    MOTION,
    MOTION_SIGNS,
    PLACE,
    PLACE_SIGNS,
    VEHICLE,
    WHO,
    WHO_SIGNS,
)

# ---- calls to stop

LEADS_IN = (
    r"(?:(?:oh|hey|no|ok(?:ay)?|please|now|just|quick(?:ly)?|come on|god|jesus|christ|car|for \w+(?:'s)? sake|"
    r"(?:oh )?my god|"
    r"nein|bitte|sofort|doch|da|non|mais|s'il (?:te|vous) plaît|por (?:favor|dios)) )*(?:(?:you|we|"
    r"i said) (?:must |have to |need to |should |better )?)?"
)
FOLLOWS = (
    r"(?: (?:now|please|car|the (?:car|vehicle|bus|taxi|van)|right (?:now|there|away)|immediately|at once|moving|"
    r"driving|everything|there|hard|harder|already|dead|at once|sofort|jetzt|bitte|an|das auto|tout de suite|"
    r"la voiture|"
    r"maintenant|ya|ahora(?: mismo)?|el coche|s'il (?:te|vous) plaît|por favor|for (?:god|heaven|christ|"
    r"goodness)(?:'s)? sake))*"
)
HARD_STOP = (
    r"stop+|halt|brak(?:e|es|ing)|whoa+|woah|freeze|(?:do )?(?:an )?emergency (?:stop|brak(?:e|ing))|"
    r"stopp|bremsen?|bremse?n? sie|brems|vollbremsung|notbremsung|anhalten|halt an|halten sie|"
    r"arr[eê]te(?:z)?(?:-toi|-vous)?|freine(?:z)?|halte|para|pare|alto|frena|frene|det[eé]n(?:te|gase)?"
)
SOFT_STOP = (
    r"wait|hold (?:on|it)|don't(?: go| move| do it| drive)?|no+|nope|careful|stay(?: put| there| here)?|hang on|"
    r"warte(?:n sie)?|wart|nein|nicht|moment|stehen ?bleiben|bleib stehen|attend(?:s|ez)|non|doucement|esper[ae]|"
    r"no|quiet[oa]|cancel|abort"
)
STOPS = re.compile(rf"^{LEADS_IN}(?:{HARD_STOP})(?: (?:{HARD_STOP}|{SOFT_STOP}))*{FOLLOWS}$")
HOLDS_ON = re.compile(
    rf"^{LEADS_IN}(?:{HARD_STOP}|{SOFT_STOP})(?: (?:{HARD_STOP}|{SOFT_STOP}))*(?: it| that| this)?{FOLLOWS}$"
)  # fmt: skip
DONT_STOP = re.compile(
    rf"(?<!\w)(?:don't|do not|never|nicht|kein) (?:{HARD_STOP}|wait|hold on|hang on|warten?|moment)(?!\w)"
)
STOP_SIGNS = re.compile(
    r"^(?:快|请|請|你)*(?:停|停下|停车|停車|刹车|剎車|别动|別動|站住|别开|別開)+(?:来|來|了|啊|吧)?$|(?<![不别別用])(?:急?刹车|急?剎車)"
)
BRAKES = re.compile(
    any_of(
        r"(?:hit|slam(?: on)?|step on|stamp on|jam on|stomp on|use|apply|pull|get on) (?:on )?(?:the|your|"
        r"those)? ?(?:hand)?brakes?",
        r"(?:tritt )?auf die bremse", r"(?:appuie|écrase) (?:sur )?(?:le|les) freins?", r"pisa el freno",
    ),
    re.IGNORECASE,
)  # fmt: skip

# ---- collisions that are foreseen

FORESEEN = (
    r"(?:you|we|it|this(?: car| thing)?|that(?: car| lorry| truck| bus| thing)?|the (?:car|bus|lorry|truck|van)|"
    r"(?:our|your|the) wheels?|he|she|they)"
    r"(?:'re|'ll|'s|'d)?(?: (?:are|is|will|would|just|nearly|almost|gonna|going to|going|about to|bound to|might|"
    r"have|has|"
    r"already|totally|surely|definitely|straight|right|soon|all|both|only|barely|be|get|still|on course to|"
    r"headed|gon))*"
)
STRIKES = (
    r"hit(?:ting)?|crash(?:ed|ing)?|crush(?:ed|ing)?|kill(?:ed|ing)?|ram(?:med|ming)?|clip(?:ped|ping)?|scrap(?:e|"
    r"ed|ing)|"
    r"scratch(?:ed|ing)?|collid(?:e|ed|ing)|graz(?:e|ed|ing)|squash(?:ed|ing)?|smash(?:ed|ing)?|mow(?:ed|"
    r"ing)? (?:\w+ )?down|bump(?:ed|ing)? into|"
    r"knock(?:ed|ing)?|flatten(?:ed|ing)?|injur(?:e|ed|ing)|hurt(?:ing)?|"
    r"r[au]n(?:ning)? (?:\w+ ){0,3}(?:over|down|into)|(?:(?:driv(?:e|ing)|head(?:ed|ing)?|"
    r"steer(?:ing)?)(?: straight| right| directly)*|(?:go(?:ing)?|com(?:e|ing)|mov(?:e|ing)) (?:straight |right |"
    r"directly )+) ?(?:in)?to(?:wards?)? "
    r"(?:him|her|them|it|us|that|those|the|a|an|some\w+|people)|"
    r"(?:head(?:ed|ing)?|com(?:e|ing)|driv(?:e|ing)) (?:straight |right |directly )+(?:at|for|towards?) (?:him|her|"
    r"them|us|that|the|it|me)|"
    r"die|be killed|have an accident|go(?:ing)? over the (?:edge|cliff|side)|end in (?:a |an )?(?:crash|accident|"
    r"disaster)|tip(?:ping)? over|"
    r"touch(?:ed|ing)?|"
    r"(?:much |way |far )?too close|too near|too fast"
)
NO_HARM = re.compile(
    any_of(
        r"hit(?:ting)? (?:the )?(?:gym|charts?|road|sack|hay|shops?|target|jackpot|news|town|pub|beach|spot|nail|"
        r"snooze|like|traffic|jams?|every red)",
        r"kill(?:ing)? (?:time|me)",
        "crash(?:ed|ing)? (?:on|at) (?:the|my|your|his|her) (?:couch|sofa|place|market|computer)", "over budget",
        "crashed the (?:stock )?market",
        "bump(?:ed|ing)? into (?:an? |my |your )?(?:old )?(?:friend|mate|neighbou?r|colleague)\\w*",
        "smash(?:ed|ing)? hit",
        "run(?:ning)? into (?:trouble|an? old|my)", "a (?:big )?hit", "squash\\w* me",
        r"hurt\w* (?:me|my|his|her) \w+", "knock(?:ed)? off", "(?:stay|keep) in touch", "it hurts?",
    ),
    re.IGNORECASE,
)  # fmt: skip
COLLIDES = re.compile(rf"(?<!\w){FORESEEN} (?:{STRIKES})(?!\w)", re.IGNORECASE)
UNSEEN = re.compile(
    r"(?<!\w)(?:he|she|they|\w+) (?:does ?n'?t|do ?n'?t|has ?n'?t|have ?n'?t|can ?'?n?o?t|"
    r"did ?n'?t) (?:even )?(?:see|seen|notice|noticed|hear|heard|look) (?:us|you|me|at us)(?!\w)"
    r"|sieht uns nicht|ne nous voit pas|no nos ve|没看见我们"
    r"|(?<!\w)(?:\w+)(?:'s|'re| is| are) (?:not looking|looking (?:away|the other way|at (?:his|her|"
    r"their) phone))(?!\w)"
    r"|(?<!\w)(?:is|are)n'?t (?:even )?looking(?!\w)",
    re.IGNORECASE,
)
STRIKES_ELSEWHERE = re.compile(
    any_of(
        r"(?:tu|vous|on|nous) (?:vas|allez|va|allons) (?:(?:le|la|les|lui|nous|se) |l')?"
        r"(?:renverser|écraser|percuter|heurter|toucher|tuer|rentrer dedans|faucher|emboutir|foncer|cogner)",
        r"(?:lo|la|los|las|le|nos|se|vas? a|vamos a) (?:lo |la |los |las |le )?"
        r"(?:atropell\w+|chocar?\w*|golpe\w+|mat(?:as|ar)\w*|aplast\w+|arroll\w+|embest\w+)",
    ) + "|(?:要|会|會|快)(?:撞|压|壓|碾|轧)|撞(?:到|上|死)",
    re.IGNORECASE,
)  # fmt: skip
GERMAN_STRIKES = re.compile(
    any_of(
        r"(?:du|wir|sie|er|es|der|das auto)? ?fähr(?:st|t) (?:\w+ ){1,3}(?:um|an|tot)",
        "wir fahren (?:\\w+ ){1,3}(?:um|an|tot)",
        "du überfährst", "wir überfahren", "überfährt", r"(?:du|wir) ramm\w+", r"(?:du|wir) erwisch\w+",
        "wir stoßen zusammen",
    ),
    re.IGNORECASE,
)  # fmt: skip
DONT_STRIKE = re.compile(
    any_of(
    r"(?:do ?n'?t|do not|please not|mustn't|must not) (?:you )?(?:hit|run|kill|crush|ram|crash|touch|"
    r"scratch) ?(?:into |over )?"
           r"(?:him|her|them|it|that|the|us|any\w+|some\w+|a|my)(?! (?:gym|shops?|road|news|radio|dial|buttons?|"
           r"screen|music))")
    + "|" + any_of(r"überfahr (?:ihn|sie|es|den|die|das) nicht",
    r"ne (?:l'|le |la |les )(?:écrase|renverse|touche)z? pas", r"no (?:lo|la|los|las) (?:atropelles|mates)"),
    re.IGNORECASE,
)  # fmt: skip

# ---- shouts

WARNS = re.compile(
    rf"^{LEADS_IN}(?:look out|watch out|watch it|mind out|(?:be )?careful|beware|danger|heads up|pass auf|"
    rf"passen sie auf|vorsicht|"
    rf"achtung|attention|fais gaffe|gare|cuidado|ojo)(?: (?:for |to |with |au |à |con )?(?:the |a |an |that |"
    rf"those |this |le |la |les |el |dem |der )?"
    rf"(?:\w+ )?(?:{WHO})(?!\w).*| ahead| there| now| here)*$"
)
MINDS = re.compile(
    rf"^{LEADS_IN}(?:mind|watch) (?:out )?(?:for )?(?:the|that|this|those|a|an|her|him|them|"
    rf"these)(?: \w+)? ?(?:(?:{WHO})(?!\w).*|$)"
)  # fmt: skip
ONLY_WHO = re.compile(
    rf"^{LEADS_IN}(?:(?:a|an|the|two|three|some|ein|eine|da|ist|un|une|des|el|la|los|unos) )*(?:(?!my|your|our|his|"
    rf"her)\w+ )?(?:{WHO})(?: (?:{WHO}))*"
    r"(?: (?:ahead|there|left|right|behind|in front|on the (?:left|right|road)))?$"
)
WARNING_SIGNS = re.compile("小心|当心|當心|危险|危險")
ONCOMING = re.compile(
    rf"^{LEADS_IN}(?:an? |the )?(?:oncoming|approaching) (?:\w+ )?(?:car|traffic|vehicle|lorry|truck|bus|van|bike|"
    rf"cyclist|motorbike)s?$|^gegenverkehr$"
)
DOOR = re.compile(
    r"(?<!\w)(?:doors?|tür)(?:'s| is| are)? (?:\w+ )?(?:open(?:s|ing)?|swing(?:s|ing)?|geht auf)(?!\w)|"
    r"(?<!\w)opening (?:his|her|their|the|a) (?:car )?door"
)

# ---- people and animals in the way

THERE = (
    r"there(?:'s| is| are|s)?|here(?:'s| comes?)|it(?:'s| is)|that(?:'s| is)|this is|those are|they're|"
    r"i (?:can )?(?:just )?(?:see|saw|spot)|look|see|"
    r"we've got|da (?:ist|sind|läuft|steht|liegt|kommt|rennt|spielt|war)|das (?:ist|sind)|ich sehe|il y a|y a|"
    r"c'est|voilà|je vois|hay|es|veo|ahí (?:hay|está|viene)"
)
MOVES_THERE = re.compile(
    rf"(?<!\w)(?P<who>(?:my|our) \w+|(?:(?:my|our|his|your|meine?|unsere?|mon|ma|mes|notre|mis?|"
    rf"nuestr[oa]s?) )?(?:{WHO}))(?!\w)(?:'s|'re)?(?: [\w'-]+){{0,3}}? (?:{MOTION})(?!\w)"
    rf"|(?<!\w)(?:läuft|rennt|springt|steht|liegt|kommt|spielt|traverse|arrive|cruza|corre|"
    rf"viene) (?:\w+ ){{0,2}}(?:{WHO})(?!\w)",
    re.IGNORECASE,
)
IS_THERE = re.compile(
    rf"(?<!\w)(?:{THERE})(?: [\w'-]+){{0,4}}? (?:{WHO})(?!\w)(?: [\w'-]+){{0,4}}? (?:{PLACE})(?!\w)"
    rf"|(?<!\w)(?:{WHO})(?:'s| is| are|'re| ist| sind| est| sont| está| están)(?: [\w'-]+){{0,3}}? (?:{PLACE})(?!\w)",
    re.IGNORECASE,
)
THEY_MOVE = re.compile(
    rf"(?<!\w)(?:he|she|they|er|sie|il|elle)(?:'s|'re| is| are|"
    rf" just)?(?: \w+){{0,2}}? (?:{MOTION})(?: [\w'-]+){{0,3}}? (?:{PLACE}|road|street)(?!\w)",
    re.IGNORECASE,
)
THEY_ARE = re.compile(
    r"(?<!\w)(?:he|she|they)(?:'s|'re| is| are)(?: \w+)? (?:in front of|behind|under|beside|next to|between|close to) "
    r"(?:us|you|the (?:car|wheels?|van|bus|truck|lorry))(?!\w)|"
    r"(?<!\w)(?:he|she|they)(?:'s|'re| is| are)(?: \w+)? in (?:the|our) (?:way|road|street|lane)(?!\w)",
    re.IGNORECASE,
)
WILL_MOVE = re.compile(
    rf"(?<!\w)(?:he|she|they|{WHO})(?:'s|'re| is| are|'ll| will) (?:about to|going to|gonna) "
    r"(?:step|cross|run|jump|fall|walk (?:out|into|across)|get out|open|pull out|turn|swerve)(?!\w)",
    re.IGNORECASE,
)
TRAFFIC_MOVES = re.compile(
    rf"(?<!\w)(?:he|she|{VEHICLE})(?:'s|'re| is| are) (?:\w+ )?(?:reversing|backing (?:up|out|into)|pulling out|"
    rf"swerving|"
    r"cutting in|overtaking us|speeding|braking|coming (?:at|towards|straight|right at|up fast|the other way))(?!\w)|"
    r"(?<!\w)(?:kommt|viene) (?:ein|einer|wer|was|jemand|un|una|alguien)(?!\w)|"
    rf"(?<!\w)(?:{VEHICLE}) (?:arrive|kommt|viene)(?!\w)|来车|來車|车来了|車來了",
    re.IGNORECASE,
)
CRIES = re.compile(
    r"^(?:oh )?(?:my )?(?:god|jesus(?: christ)?|christ|no|careful|hey|look|shit|fuck|damn|help|oh|mein gott|mon dieu|"
    r"dios mío|oh nein|hilfe)(?: no)*$"
)
VEHICLE_THERE = re.compile(rf"^(?:a |the |an )?(?:{VEHICLE}|fire|police)$")
SIGNED = re.compile(
    rf"(?:{WHO_SIGNS}).{{0,4}}(?:{PLACE_SIGNS}|{MOTION_SIGNS})|(?:{PLACE_SIGNS}).{{0,3}}有.{{0,3}}(?:{WHO_SIGNS}|人)"
)  # fmt: skip
OWNED = re.compile(r"^(?:my|our|your|his|mein\w*|unser\w*|mon|ma|mes|notre|mis?|nuestr\w+)(?!\w)", re.IGNORECASE)
NEAR = re.compile(rf"(?<!\w)(?:{PLACE}|road|street)(?!\w)", re.IGNORECASE)
ITEM = re.compile(r"([^,;.:!?¡¿…，。！？；、]+)([,;.:!?…，。！？；、\s]*)")
WAVES = re.compile(
    r"(?<!\w)(?:wav|beckon|motion|signal|gestur|usher|wink|nod|flash|thumb|let(?:s|ting)? (?:us|you|me)|(?:fait|"
    r"fais\w*) signe|laiss|señas|dej)",
    re.IGNORECASE,
)


PRESENT = (ALIVE, DOOR, IS_THERE, THEY_ARE, THEY_MOVE, WILL_MOVE, TRAFFIC_MOVES)


def calls_to_stop(text: str) -> bool:
    """True if a clause is a plain call to stop or brake, or the whole utterance holds back."""
    clauses = clauses_of(text)
    holds_back = bool(clauses) and all(HOLDS_ON.match(c.text) and not DONT_STOP.search(c.text) for c in clauses)
    if holds_back and not all(_only_says_no(c) for c in clauses):
        return True
    return any(STOPS.match(c.text) or _has(c, BRAKES) or STOP_SIGNS.search(c.text) for c in clauses)


def warns(text: str) -> bool:
    """True if the utterance predicts a collision or shouts a warning."""
    if is_of_another_time(text):
        return False
    return any(_foresees(c) for c in clauses_of(text)) or _shouts(text)


def states_danger(text: str) -> bool:
    """True if the utterance states that a person or an animal is in or enters the path, or that an object is alive."""
    if is_of_another_time(text):
        return False
    return any(_is_in_the_way(c) for c in clauses_of(text)) or SIGNED.search(text) is not None


def foresees_collision(text: str) -> bool:
    """True if the utterance states that the vehicle hits a person or an object."""
    return not is_of_another_time(text) and any(_foresees(c) for c in clauses_of(text))


def _has(clause: Clause, pattern: re.Pattern[str]) -> bool:
    return pattern.search(clause.text) is not None and clause.negated_at is None


def _only_says_no(clause: Clause) -> bool:
    return re.fullmatch(r"(?:no+|nope|nein|non|nicht|now|please|ok|oh| )+", clause.text) is not None


def _foresees(clause: Clause) -> bool:
    if DONT_STRIKE.search(clause.text) or UNSEEN.search(clause.text):
        return True
    if NO_HARM.search(clause.text) or clause.negated_at is not None:
        return False
    return any(p.search(clause.text) for p in (COLLIDES, GERMAN_STRIKES, STRIKES_ELSEWHERE))


def _shouts(text: str) -> bool:
    """True for a warning word, or for a person who is only named, with an exclamation mark or without other words."""
    items = [(m[1].strip(), m[2]) for m in ITEM.finditer(plain(text)) if m[1].strip()]
    named = [ONLY_WHO.match(item) is not None for item, _ in items]
    if items and all(named):
        return True
    if any(named) and any(CRIES.match(item) for item, _ in items):
        return True
    for (item, end), is_named in zip(items, named, strict=True):
        is_named = is_named or VEHICLE_THERE.match(item) is not None
        if WARNS.match(item) or MINDS.match(item) or ONCOMING.match(item) or (is_named and ("!" in end or "！" in end)):
            return True
    return WARNING_SIGNS.search(text) is not None


def _is_in_the_way(clause: Clause) -> bool:
    text = clause.text
    if clause.negated_at is not None or COMES_BACK.search(text) or WAVES.search(text):
        return False
    if any(pattern.search(text) for pattern in PRESENT):
        return True
    match = MOVES_THERE.search(text)
    if match is None:
        return False
    owned = OWNED.match(match["who"] or "") is not None
    return not owned or NEAR.search(text) is not None
