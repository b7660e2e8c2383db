"""Recognizes that a person or a sign outside forbids the vehicle to proceed: an officer, a flagger, or "he"."""

from __future__ import annotations

import re

from stucksolver.word_safeguards.clauses import Clause, any_of, clauses_of, is_of_another_time

WHO_DIRECTS = (
    r"police(?:m[ae]n|wom[ae]n)?|cops?|officers?|constables?|wardens?|guards?|flag ?(?:gers?|m[ae]n|person)|"
    r"stewards?|marshals?|"
    r"lollipop (?:lady|man)|sheriff|trooper|bobby|soldiers?|fire(?:m[ae]n|fighters?)|workm[ae]n|workers?|builders?|"
    r"foreman|"
    r"attendants?|bouncer|conductor|security|driver|he|she|they|somebody|someone|guy|man|woman|lady|bloke|people|"
    r"signs?|"
    r"polizist(?:in)?|polizei|beamte[rn]?|schülerlotse|bauarbeiter|ordner|feuerwehr\w*|er|sie|man|"
    r"policiers?|agents?|gendarmes?|flics?|police|ouvrier|pompiers?|il|elle|on|"
    r"polic[ií]as?|agente|guardia|bombero|obrero|señor|[eé]l|ella|nos"
)
US = (
    r"(?:us|you|me|anybody|anyone|everybody|everyone|all|cars?|traffic|the (?:traffic|car|cars|lane)|(?:our|this|"
    r"my) (?:lane|side|car|way)|people)"
)
THROUGH = r"(?:through|past|by|in|on|across|over|further|go|pass|drive|enter|continue|proceed|move|cross|turn|out)"

FORBIDS = re.compile(
    any_of(
        # Words and signals.
        rf"(?:{WHO_DIRECTS})(?:'s)?(?: [\w'-]+){{0,5}}? (?:says?|said|tells?|told|telling|saying|shouts?|shouting|"
        rf"signal\w*|sign(?:s|ing)|signed|indicat\w+|motion\w*|gestur\w*|"
        rf"mean(?:s|ing)?|wants?|orders?|ordered|ask(?:s|ed|ing)?|insists?|shows?|showing|expects?|warns?|warned|"
        rf"yell\w*|calls?|calling|point\w*|wav\w+|need(?:s|ing)?)"
        rf"(?: [\w'-]+){{0,5}}? (?:no|not|stop(?:ped)?|wait|stay|halt|back|can't|cannot|mustn't|may not|must not|"
        rf"shouldn't|aren't|isn't|don't|brake|turn (?:around|round|back)|red|away|off|hold)",
        # Refusals.
        rf"(?:wo|do|does|did|is|are|has|have|ca|could|would|was|were)(?: ?n't| not|nt) (?:let(?:ting)?|allow(?:ed|"
        rf"ing)?|want(?:s|ing)?|wav(?:e|ed|ing)|giv(?:e|en|ing)|beckon\w*|permit\w*|signal\w*|motion\w*|"
        rf"invit\w*)(?: [\w']+){{0,2}}? (?:{US}|{THROUGH}|to)",
        rf"(?:not|never|nobody|no one|none|hardly|stopped|stops?|refus\w+|"
        rf"declin\w+)(?: [\w'-]+){{0,3}}? (?:let(?:s|ting)?|allow\w*|wav\w+|beckon\w*|"
        rf"permit\w*)(?: [\w']+){{0,2}}? ?(?:{US}|{THROUGH})",
        rf"(?:not|n't|never) (?:allowed|permitted|supposed|meant|free) (?:to )?(?:{THROUGH}|enter|be here)",
        rf"not (?:to be )?(?:let|waved) {THROUGH}",
        r"(?:can't|cannot|mustn't|may not|must not|shouldn't|not allowed to|not) (?:go|get|drive|pass|come|"
        r"be) (?:through|past|by|in|on|across|any further)",
        r"refus\w+", r"forbid\w*|forbade|forbidden", r"prohibit\w*", r"bar(?:s|ring|red) (?:us|the way|our way)",
        r"ban(?:s|ned) (?:us|cars|traffic)",
        # Gestures.
        r"(?:hold|put|rais|lift|stretch|stick|throw|thrust)\w*(?: (?:up|out))?(?: (?:his|her|their|a|an|the|one|"
        r"both|two|that))*(?: [\w-]+)? (?:hands?|arms?|palms?|paddle|baton|stick|lollipop|flag|fist)",
        r"(?:show|has|have|with|got|flash)\w*(?: (?:his|her|their|a|an|the|one|both|two|that|"
        r"us))*(?: [\w-]+)? (?:hands?|arms?|palms?|paddle|baton|stick|lollipop|flag|fist|sign) (?:up|out|raised|"
        r"high|in the air|towards? us|against us)", "show(?:s|ing|ed) (?:us )?(?:his|her|the|a) palm",
        r"(?:hands?|arms?|palms?|paddle|baton|sign|flag|lollipop)(?: is| are|'s)? (?:up|out|raised|down|crossed|"
        r"turned to (?:stop|red)|to stop)",
        r"sh(?:ak(?:es|ing|e|en)|ook) (?:his|her|their|the) heads?",
        r"(?:show|hold|rais|wav|put|turn|has|have|with|flash|got|display|see)\w* (?:[\w']+ ){0,3}(?:red|stop|"
        r"black) (?:flag|sign|paddle|baton|side|disc|card)",
        r"(?:red|stop) (?:flag|sign|paddle)(?: is|'s)? (?:up|out|raised)",
        r"(?:sign|paddle|lollipop)\w* (?:\w+ )?(?:to|on|says|reads|at|shows) (?:stop|red)",
        r"(?:waves?|waving|waved) (?:a )?red",
        rf"wav(?:es?|ed|ing) {US} (?:back|away|off|down|aside|to (?:stop|the side)|elsewhere)",
        r"wag\w* (?:his|her|a) finger", r"thumbs? down", r"crosse[sd] (?:his|her) arms",
        r"(?:block|clos|seal|shut|cordon)\w*(?: off)? (?:us|our|the|this|that) ?(?:way|road|street|lane|path|"
        r"junction|entrance|bridge|off)?",
        rf"(?:stop(?:s|ping|ped)|halt(?:s|ing|ed)|hold(?:s|ing) (?:up|back)|keep(?:s|ing) back|turn(?:s|"
        rf"ing) (?:back|away)) {US}", rf"turn(?:s|ing|ed) {US} (?:back|away|round)",
        r"step(?:s|ped|ping) (?:out )?in front of us", "not yet", "no (?:entry|access|passage|way through)",
        rf"keep(?:s|ing)? {US} (?:out|back|away)", rf"hold(?:s|ing)? {US} (?:back|up)", "stopped waving",
        r"(?:nobody|no one)(?:'s| is) (?:allowed|permitted|let)",
        r"step(?:s|ped|ping) (?:out )?into the (?:road|street|lane)", "(?:get|stay|keep|go) back",
        # German
        r"(?:läss?t|lassen|winkt|winken|will|wollen) (?:uns|niemanden|keinen|mich|dich) (?:\w+ ){0,2}?(?:nicht|"
        r"keinen|niemanden|zurück|weg|raus|an den rand|stopp)", r"lässt (?:niemanden|keinen)",
        r"(?:dürfen|darf|können|kann|sollen|soll) (?:\w+ ){0,3}?nicht (?:\w+ )?(?:durch|weiter|vorbei|fahren|rein)",
        r"(?:hält|hebt|streckt|zeigt) (?:\w+ ){0,3}?(?:kelle|hand|arm|hände|stopp\w*|rot\w*)",
        r"(?:sagt|zeigt|ruft|winkt|bedeutet)(?: \w+){0,4} (?:nein|nicht|halt|stopp?|warten|anhalten|zurück|stehen)",
        r"schüttelt den kopf", r"verbiete\w*|verboten|gesperrt|untersag\w*", r"hält uns (?:an|auf|zurück)",
        # French
        r"(?:ne |n')(?:\w+ )?(?:nous |les? |vous )?(?:laisse|peut|peuvent|peux|pouvons|doit|faut|veut|a|autorise|"
        r"permet)\w* (?:\w+ )?(?:pas|personne|plus)",
        r"(?:lève|lèvent|tend|montre|agite) (?:\w+ ){0,2}?(?:main|bras|paume|bâton|drapeau|panneau)",
        r"(?:fait|fais|font) signe (?:que non|d'(?:arrêter|attendre)|de (?:s'arrêter|stopper|reculer|rester|"
        r"ne pas))",
        r"(?:dit|crie|demande|ordonne)(?: \w+){0,3}? (?:non|stop|d'(?:attendre|arrêter)|de (?:s'arrêter|stopper|"
        r"reculer|rester|ne pas))", r"secoue la tête", r"interdi\w*",
        r"(?:bloque|barre|ferme|arrête) (?:nous|la|le|les|notre)",
        # Spanish
        r"no (?:nos |me |te |se |les? )?(?:deja|dejan|permite|permiten|puede|podemos|pueden|quiere|"
        r"autoriza)\w*(?: \w+){0,2}",
        r"(?:levant|alz|muestr|ense[ñn])\w* (?:\w+ ){0,2}?(?:mano|brazo|palma|bandera|señal|paleta|bast[oó]n)",
        r"(?:señas?|señal(?:es)?|gestos?) (?:de|para) (?:que )?(?:parar|pare\w*|esperar?|espere\w*|alto|deten\w*|"
        r"retroce\w*|no)", r"(?:dice|grita|ordena|pide)(?: \w+){0,3}? (?:no|alto|pare\w*|parar|esper\w+|deten\w*)",
        r"niega con la cabeza", r"proh[ií]b\w*|prohibid\w*", r"(?:bloque|cierra|cerr|cort)\w* (?:el|la|nuestro|nos)",
    )
    + "|不(?:让|讓|准|许|許|允许|允許)|(?:让|讓|叫|(?<!不)要)(?:我们|我們|咱们)?(?:停|等|别|別|后退|退)|"
    "举(?:起)?手|舉手|摇头|搖頭|禁止|拦住|攔住|红旗",
    re.IGNORECASE,
)  # fmt: skip
ABOUT_DIRECTING = re.compile(
    any_of(WHO_DIRECTS, r"we(?:'re)?", "wave", "nobody", "no one", "road", "us"),
    re.IGNORECASE,
)  # fmt: skip
NOT_FOR_US = re.compile(
    any_of(
        r"(?:wav\w+|signal\w*|sign|gesture|beckon\w*|that)(?: \w+)? (?:is|was|are|were)(?:n't| not) (?:for|at|"
        r"meant for|to) (?:us|me)",
        r"wav(?:es|ed|ing) (?:the |at )?(?:others?|him|her|them|somebody else|someone else|other cars?)",
        r"(?:not|n't) (?:wav\w+|mean\w*|look\w*|beckon\w*|point\w*) (?:at |to )?us",
    ),
    re.IGNORECASE,
)  # fmt: skip
PRESUPPOSES = re.compile(r"^\W*(?:why|what|who|where|when|how|warum|wieso|pourquoi|por qué|为什么)", re.IGNORECASE)
NO_ORDER = re.compile(
    any_of(
        r"we(?:'re| are) (?:hold|block|stopp)ing", "folded", "lower(?:ed|ing|s)", "dropped", "away now", "sign away",
        "flag down", "hand down", "i can't",
        "my \\w+", "the doctor", "smoke", "eat", "drink", "sugar", "music", "phone", "tablet", "no problem",
        r"(?:\w+n't|not) (?:stop|block|forbid|hold|mind|refus)\w*",
        r"(?:says?|said) (?:no|not to) (?:worry|problem)", "to stop (?:worrying|waiting|dithering|hesitating)",
        "not to (?:wait|stop|hesitate)",
        r"(?:don't|do not|needn't|no need to) (?:have to |need to )?(?:wait|stop)", r"no longer (?:have to|need to)",
        "nicht (?:warten|anhalten|halten)", r"pas (?:besoin|attendre|s'arrêter)", "no (?:esper|par|hace falta)\\w*",
        "用不着|不用(?:等|停)",
    ),
    re.IGNORECASE,
)  # fmt: skip
"""Prohibitions that do not concern the drive, or mean the opposite."""


def forbids(text: str) -> bool:
    """True if the utterance states that a person forbids the vehicle to proceed, or waves to another road user."""
    if PRESUPPOSES.search(text) or is_of_another_time(text):
        return False
    return any(_forbids(clause) for clause in clauses_of(text))


def _forbids(clause: Clause) -> bool:
    text = clause.text
    if NO_ORDER.search(text):
        return False
    if NOT_FOR_US.search(text):
        return True
    return FORBIDS.search(text) is not None and (ABOUT_DIRECTING.search(text) is not None or _is_short_order(text))


def _is_short_order(text: str) -> bool:
    return re.search(r"[\u4e00-\u9fff]|proh|forbid|interdi|verbot", text) is not None
