"""Checks the words themselves for a claim that gives a permission: asserted, denied, or neither.

A claim counts only if the network detects it and the words assert it: two independent methods must agree.
"""

from __future__ import annotations

import re
from enum import Enum
from types import MappingProxyType

from stucksolver.scene.interpretation import Claim
from stucksolver.word_safeguards.clauses import Clause, any_of, clauses_of, is_question


class Evidence(Enum):
    """Evidence of an utterance for a claim."""

    ASSERTED = "asserted"
    DENIED = "denied"
    NEITHER = "neither"


SOFT = re.compile(
    any_of(
        r"(?:\w+ )?bags?", r"\w*bag", "plastic", "paper", "news ?papers?", r"card ?board", r"cartons?",
        r"box(?:es)?", "litter",
        "trash", "rubbish", "garbage", r"lea(?:f|ves)", "foam", "styrofoam", "polystyrene", "wrapp(?:er|ing)s?",
        "packaging", "liner",
        "sack", "sheet(?:ing)?", "tarp(?:aulin)?", "cloth", "rags?", "shirt", "jacket", "towel", "balloons?",
        "cups?", "tissues?",
        "foil", "film", "soft", "squashy", "light as a feather", "empty", "harmless", "feathers?", "straw", "hay",
        "pillow ?case", "petals?", "ribbons?", "tumble ?weed", "confetti", "grass", "twigs?", "noodles",
        r"\w*tüten?", r"\w*beutel", "plastik", "papier", "karton", r"\w*pappe", "müll", "laub", "blätter",
        "schaumstoff", "lappen", "weich", r"leer\w*", "zeitung",
        "sacs?", "sachets?", "plastique", "carton", "feuilles?", "ordures?", "déchets?", "mou", "vide", "chiffon",
        "journal",
        "bolsas?", "plástico", "papel", "cart[oó]n", "caja", "hojas?", "basura", "bland[oa]", "vac[ií][oa]", "trapo",
        "periódico",
    ) + "|袋|塑料|塑膠|纸|紙|垃圾|树叶|樹葉|软|軟|空的|泡沫",
    re.IGNORECASE,
)  # fmt: skip
TAKES_BACK = re.compile(
    r"^(?:i (?:think|see|guess) )?(?:no )?(?:it|that|this)(?: really)? ?(?:isn't|isnt|is not|wasn't|was not|ain't|"
    r"'s not|doesn't)$|not what (?:it|you|we)",
    re.IGNORECASE,
)
"""Denial of another clause: "I thought it was a bag, but it isn't"."""
WAVED = re.compile(
    any_of(
        r"wav(?:e|es|ed|ing)(?! (?:us |me |you )?(?:back|away|off|down|aside|to stop|red|a red|his|her|"
        r"like))(?: \w+){1,2}", r"beckon\w*", r"usher\w*", r"wink\w* (?:us|me)",
        r"(?:motion|signal|gestur|sign)\w* (?:for )?(?:us|me|you|that|to go|go)(?: \w+)*",
        r"(?:nod|flash|blink)\w*(?: \w+)*", "thumbs? up", "go(?:es)? ahead",
        r"giv(?:es|ing|en|e)(?: us)?(?: \w+)? (?:way|room|the (?:go|nod|ok|okay|all[- ]clear|sign|thumbs))",
        r"let(?:s|ting)? (?:us|you|me|our side|our lane|cars)(?: \w+)*",
        r"(?:says?|said|means|tells us) (?:that )?(?:we|you|it's|to) (?:can|may|could|should|go|ok|okay|our turn|"
        r"clear|drive|come|cross|pass|through)(?: \w+)*",
        r"(?:we|you) (?:can|may) (?:go|pass|drive|come|cross)(?: \w+)*",
        r"(?:stopp(?:ed|ing)|wait(?:s|ing|ed)|brak\w+|slow\w+|holding back) (?:for|to let) (?:us|you|me)",
        "mak(?:es|ing) (?:room|way|space)", r"invit\w*", r"pull\w* (?:over|in|aside|back) (?:for|to let) us",
        r"(?:sign|paddle|lollipop)(?: \w+)* (?:to|on|says|shows?) (?:go|slow|green)",
        "green (?:flag|side|paddle|sign)", "says go", "after you", r"pointing (?:at )?us (?:to|through|on|past|by)",
        r"lift\w* the (?:tape|barrier|gate|chain|rope)",
        "(?:gave|gives|given) (?:us|you) (?:the|a) (?:light|go|nod|sign|wave)", "sees us", "our turn", "come on",
        r"\w*wink(?:t|en)(?: \w+)+", "gewinkt", "gewunken", r"lässt (?:uns|mich)(?: \w+)*", "macht (?:uns )?platz",
        "gibt (?:uns )?(?:lichthupe|zeichen)", r"wir dürfen(?: \w+)*",
        r"(?:fait|fais|font) signe(?: (?:de|d'|qu'on|que)? ?(?:passer|avancer|y aller|rouler|continuer|on peut|"
        r"\w+))?", r"laiss\w+ passer", "laissent? (?:entrer|passer)", "on peut (?:y aller|passer)",
        r"(?:señas?|señal(?:es)?|gestos?)(?: (?:de|para|con la mano))?(?: (?:que )?(?:pas\w+|avan\w+|sig\w+|"
        r"cruc\w+|mano))?", r"(?:nos|me) (?:deja|dejan|cede|ceden)(?: \w+)*", "da(?:n)? paso",
        "podemos (?:pasar|ir|seguir)",
    ) + "|挥手|揮手|招手|示意|让我们(?:过|走|先)|讓我們(?:過|走|先)|让路|讓路",
    re.IGNORECASE,
)  # fmt: skip
BROKEN = re.compile(
    any_of(
        r"broken?", "broke down", "out of (?:order|service|action)", r"defect\w*", "faulty", "fault", "stuck",
        "jammed", "dead", "bust(?:ed)?", r"malfunction\w*",
        "on the (?:blink|fritz)", "knackered", "kaputt", "buggered", "haywire", "hangs?", "hung", "frozen", "out",
        "given up", "failed", "down",
        "forever", "dark", "unlit", r"for (?:\w+ )?(?:days?|hours?|weeks?|minutes|ages|ever)", r"since \w+",
        "always (?:red|on red)", "permanently", "all (?:day|night|morning)",
        "defekt", "gestört", "spinnt", "hängt", "ausgefallen", "außer betrieb", r"seit \w+", "en panne", "cassée?",
        "bloquée?", "hors service", "détraquée?",
        r"averiad[oa]", "rot[oa]", r"descompuest[oa]", r"estropead[oa]", r"atascad[oa]", "dañad[oa]",
        "fuera de servicio",
    ) + "|坏|壞|故障|失灵|卡住|一直(?:是)?红",
    re.IGNORECASE,
)  # fmt: skip
WORKS = re.compile(
    any_of(
        r"work\w*", r"chang\w*", r"turn\w*", r"switch\w*", "go(?:es|ing)?", "green", r"com\w+", r"mov\w*",
        r"function\w*", "operational", "in order", r"respond\w*",
        "geht", "funktioniert", "schaltet", "grün", "wird", "marche", "fonctionne", "change", "vert", "passe",
        "funciona", "cambia", "verde",
    ) + "|变|變|工作|绿",
    re.IGNORECASE,
)  # fmt: skip
IN_ORDER = re.compile(
    any_of(
        r"works?(?: \w+)?", r"working(?: \w+)?", "fixed", "repaired", "fine", "in order", "funktioniert", "geht wieder",
        "repariert", "marche", "fonctionne", "réparé", "funciona", "arreglado",
    ) + "|修好|正常",
    re.IGNORECASE,
)  # fmt: skip
STAYS_PUT = re.compile(
    any_of(
        r"park\w*", r"unload\w*", r"load\w*", r"deliver\w*", r"abandon\w*", r"br(?:oke|oken|eak\w*) ?down",
        "breakdown", r"stay\w*", r"stand\w*", r"been there", "there since",
        "hours?", "all (?:day|night|morning|afternoon|week)", "ages", "forever", "lunch", "flat (?:tyre|tire)",
        "puncture", "dead", "gone", "long", "asleep", r"mov(?:ing|es|ers?) (?:house|furniture)",
        r"park\w*|laden|lädt|ausladen|panne|lange|dauert|garée?|décharge|livre|panne|descarg\w+|aparcad\w+|"
        r"estacionad\w+|averiad\w+",
    ) + "|停在|卸货|卸貨|抛锚|很久",
    re.IGNORECASE,
)  # fmt: skip
LEAVES = re.compile(
    any_of(
        r"mov\w*", r"com\w+", "back", r"leav\w*", r"driv\w*", "go(?:es|ing)?", r"return\w*", "anywhere", "budge",
        "here", r"start\w*", "in (?:it|there)", "soon", "hurry", "anytime", r"shift\w*", "ready",
        "zurück", "weg", "fährt", "weiter", "bald", "drin", r"revien\w*", r"repart\w*", "bouge", "part", r"vuelv\w*",
        r"regres\w*", r"muev\w*", "dentro",
    ) + "|回来|回來|开走|開走|动|動",
    re.IGNORECASE,
)  # fmt: skip
ABOUT_TO_LEAVE = re.compile(
    any_of(
        "about to (?:leave|move|go|drive|start|pull)",
        "(?:only|just) (?:waiting|stopping|a (?:moment|minute|second|sec))", r"(?:is|'s|are|'re) (?:just )?leaving",
        "any (?:moment|second|minute)", "in a (?:moment|minute|second|sec)",
        "not (?:for )?long", "gleich", "sofort", "bientôt", "tout de suite", "enseguida", "ya se va",
    ) + "|马上|馬上",
    re.IGNORECASE,
)  # fmt: skip


def evidence_for(claim: Claim, text: str) -> Evidence:
    """Return the evidence of the words for a claim that gives a permission."""
    evidence = _FINDERS[claim](clauses_of(text))
    return Evidence.NEITHER if evidence is Evidence.ASSERTED and is_question(text) else evidence


def denies_softness(text: str) -> bool:
    """True if the utterance states that an object is no bag, no paper, or not soft."""
    clauses = clauses_of(text)
    named = any(SOFT.search(clause.text) for clause in clauses)
    return any(clause.denies(SOFT) or (named and TAKES_BACK.search(clause.text)) for clause in clauses)


def _soft(clauses: tuple[Clause, ...]) -> Evidence:
    if any(c.is_negated(SOFT) or TAKES_BACK.search(c.text) for c in clauses):
        return Evidence.DENIED
    return _asserted(clauses, SOFT)


def _waved(clauses: tuple[Clause, ...]) -> Evidence:
    if any(c.denies(WAVED) for c in clauses):
        return Evidence.DENIED
    return _asserted(clauses, WAVED)


def _broken(clauses: tuple[Clause, ...]) -> Evidence:
    works = any(c.asserts(IN_ORDER) for c in clauses)
    if works or any(c.denies(BROKEN) and not c.is_negated(WORKS) for c in clauses):
        return Evidence.DENIED
    stays = any(c.is_negated(WORKS) for c in clauses)
    return Evidence.ASSERTED if stays else _asserted(clauses, BROKEN)


def _long_stay(clauses: tuple[Clause, ...]) -> Evidence:
    if any(c.denies(STAYS_PUT) and not c.is_negated(LEAVES) for c in clauses) or any(
        c.mentions(ABOUT_TO_LEAVE) for c in clauses
    ):
        return Evidence.DENIED
    plain = all(c.negated_at is None for c in clauses)
    stays = plain or any(c.is_negated(LEAVES) or c.asserts(STAYS_PUT) for c in clauses)
    return Evidence.ASSERTED if stays else Evidence.NEITHER


def _asserted(clauses: tuple[Clause, ...], pattern: re.Pattern[str]) -> Evidence:
    return Evidence.ASSERTED if any(c.asserts(pattern) for c in clauses) else Evidence.NEITHER


_FINDERS = MappingProxyType(
    {Claim.SOFT_OBJECT: _soft, Claim.WAVED_THROUGH: _waved, Claim.BROKEN_LIGHT: _broken, Claim.LONG_STAY: _long_stay}
)
GIVES = frozenset(_FINDERS)
"""Claims that permit an action or make the vehicle less patient; see docs/words.md."""
