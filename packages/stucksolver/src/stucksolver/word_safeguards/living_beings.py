"""Words for people, animals and hard objects, and for their motion into the path, in the interpreter's languages."""

from __future__ import annotations

import re

from stucksolver.word_safeguards.clauses import any_of

WHO = (
    r"child(?:ren)?|kids?|boys?|girls?|bab(?:y|ies)|toddlers?|infants?|prams?|strollers?|buggy|push ?chairs?|"
    r"m[ae]n|wom[ae]n|lad(?:y|ies)|guys?|blokes?|chaps?|persons?|people|pedestrians?|passers?-?by|grann(?:y|ies)|"
    r"pensioners?|"
    r"somebody|someone|bod(?:y|ies)|corpse|human|walkers?|joggers?|runners?|skaters?|"
    r"cyclists?|bikers?|bikes?|bicycles?|motor(?:bikes?|cycles?|cyclists?)|scooters?|mopeds?|wheel ?chairs?|"
    r"dogs?|dogg(?:y|ie)|pupp(?:y|ies)|cats?|kitt(?:en|y|ies)s?|animals?|deer|horses?|pon(?:y|ies)|cows?|calf|"
    r"sheep|lambs?|"
    r"goats?|pigs?|ducks?|ducklings?|geese|swans?|birds?|hedgehogs?|fox(?:es)?|rabbits?|hares?|squirrels?|badgers?|"
    r"moose|elk|turtles?|tortoises?|snakes?|frogs?|toads?|hens?|chickens?|rats?|raccoons?|possums?|monkeys?|goose|"
    r"bears?|boars?|"
    r"creatures?|feet|foot|legs?|fingers?|toes?|"
    # German
    r"kind(?:er)?|junge|mädchen|baby|kinderwagen|mann|männer|frau(?:en)?|mensch(?:en)?|person(?:en)?|leute|"
    r"jemand(?:en)?|"
    r"fußgänger(?:in)?|fussgänger|oma|radfahrer(?:in)?|radler|fahrrad|motorrad|roller|rollstuhl|hund(?:e)?|katzen?|"
    r"kätzchen|"
    r"tier(?:e)?|igel|reh(?:e)?|pferd(?:e)?|kuh|kühe|schafe?|enten?|vogel|körper|leiche|"
    # French
    r"enfants?|gamins?|gosses?|gar[cç]on|fille(?:tte)?|bébé|poussette|homme|femme|dame|monsieur|gens|"
    r"personne(?=s? (?:est|sur|qui|dans|traverse|derrière|devant|âgée))|"
    r"quelqu'un|piétons?|cyclistes?|vélos?|motos?|chiens?|chats?|chatons?|animal|animaux|hérisson|chevreuil|cheval|"
    r"vaches?|corps|"
    # Spanish
    r"niñ[oa]s?|bebé|cochecito|hombres?|mujer(?:es)?|señor(?:a|es)?|gente|persona|alguien|peat[oó]n(?:es)?|"
    r"ciclistas?|bicis?|"
    r"bicicletas?|motos?|perr(?:o|a|ito)s?|gat(?:o|a|ito)s?|animal(?:es)?|erizo|ciervo|caballos?|vacas?|cuerpo"
)
WHO_SIGNS = (
    "小?孩子?|儿童|兒童|婴儿|有人|行人|老人|老太太|女人|男人|骑车|"
    "自行车|[一只條条](?:狗|猫|貓)|狗|猫|貓|动物|動物|刺猬|鹿|活的"
)
ALIVE = re.compile(
    any_of(
        "alive", "living (?:thing|creature|being)s?", "(?:something|somebody|someone) living", "breath(?:es|ing)",
        r"bleed\w*", r"twitch\w*", r"wriggl\w*", r"crawl\w*", r"whimper\w*",
        r"mov(?:es|ed|ing) (?:by itself|on its own|inside|in there|again)",
        r"(?:it|that|that thing|(?:the|that) (?:bag|box|bundle|thing|sack|blanket))(?:'s| is| has)? (?:just |"
        r"really )?mov(?:ed|ing)", "(?:it|that) moves",
        "asleep in (?:it|there)", "heartbeat", "(?:has|have|with) (?:eyes|legs|a tail|fur|feet)",
        "lebt", "lebend(?:ig\\w*)?", "lebendes", "atmet", "bewegt sich", "blutet", "vivante?", "bouge", "respire",
        "vivo",
        "viva", "se mueve", "respira", "sangra",
    ) + "|活着|活的|在动|在動|呼吸",
    re.IGNORECASE,
)  # fmt: skip
HARD = re.compile(
    any_of(
        "rocks?", "stones?", "boulder", r"bricks?", "concrete", "cement", "glass", "metal", "iron", "steel", "nails?",
        "screws?", "wood(?:en)?", "logs?", "beams?", "planks?", "bottles?", "kerb", "pipes?", "wheel", "tyre", "tire",
        "heavy", "hard", "solid", "sharp", "anvil", "toolbox", "full of", "battery", "gas (?:bottle|cylinder)",
        "explosives?",
        r"steine?", r"ziegel\w*", "beton", "glas", "scherben", r"eisen\w*", "nägel", "schwer", "hart", "holz", "voller",
        "pierres?", "rochers?", "briques?", "béton", "verre", "fer", "clous", "lourd", "dur", "bois", "plein de",
        r"piedras?", "rocas?", "ladrillos?", "hormig[oó]n", "vidrios?", "hierro", "clavos", "pesad[oa]", "dur[oa]",
        "llen[oa] de",
    ) + "|石头|石頭|砖|磚|水泥|玻璃|铁|鐵|钉子|很硬",
    re.IGNORECASE,
)  # fmt: skip
ROAD = (
    r"(?:the |this |our |your |its |a |that )?(?:middle of the )?(?:road|street|way|lane|path|car|van|bus|truck|"
    r"lorry|vehicle|taxi|trailer|hedge|"
    r"wheels?|tyres?|bonnet|hood|bumper|blanket|tarp(?:aulin)?|box|bag|sack|cardboard|crossing|crosswalk|ground|tarmac|"
    r"asphalt|junction|zebra)"
)
PLACE = (
    rf"(?:in|on|under|underneath|behind|beside|beneath|inside|between|near|by|off|into|onto|across|over|along|around|"
    rf"next to|close to|in front of|right in front of|ahead of|out of|out from behind) (?:{ROAD}|us|it|me|there|"
    rf"you)|in the way|ahead|right there|"
    rf"in front|inside|underneath|(?:auf|hinter|unter|vor|neben|zwischen|in|über) (?:der|dem|die|den|das|uns|einem|"
    rf"einer) ?(?:straße|"
    r"fahrbahn|spur|weg|auto|wagen|bus|laster|lkw|lieferwagen|rad|räder|tüte|decke|karton)?|"
    r"(?:sur|dans|derrière|sous|devant|au milieu de|à côté de|entre) (?:la|le|les|l'|nous|du)? ?(?:route|rue|"
    r"chaussée|voie|voiture|"
    r"camion|camionnette|bus|roues?|sac|carton|nous)|"
    r"(?:en|sobre|detrás de|debajo de|delante de|dentro de|entre|junto a) (?:la|el|los|las|nosotros|l)? ?(?:calle|"
    r"carretera|"
    r"camino|coche|camión|furgoneta|autobús|ruedas?|bolsa|caja|nosotros)|delante|detrás"
)
PLACE_SIGNS = "路上|车后|車後|后面|後面|前面|车下|車下|里面|裡面|马路|馬路"
MOTION = (
    r"(?:run|runn|stepp|cross|walk|jump|fall|swerv|climb|crawl|ly|kneel|sitt|stand|hid|play|dart|chas|turn|wobbl|"
    r"stumbl|"
    r"rush|dash|dodg|trip|roll|slid|limp|kick|approach|reach|lean|weav|emerg|appear|cutt|pull|com|gett|bend|mov)ing|"
    r"(?:ran|walked|crawled|climbed|wandered|came)(?! (?:here|home|yesterday))|fell|jumped|stepped|darted|lies|"
    r"runs|crosses|steps|walks|trapped|stuck|injured|hurt|"
    r"läuft|rennt|springt|steht|liegt|kommt|geht|spielt|überquert|fällt|fiel|traverse(?:nt)?|court|courent|saute|tombe|"
    r"est tombé|arrive|marche|joue(?:nt)?|est couché|dort|cruz(?:a|an|ando)|corr(?:e|en|iendo)|salt(?:a|ando)|"
    r"ca(?:e|yó)|"
    r"viene|camin(?:a|ando)|jug(?:ando)|juega|tumbad[oa]|tirad[oa]"
)
MOTION_SIGNS = "跑|过马路|過馬路|横穿|冲出|衝出|走过来|躺|倒在|摔倒"
VEHICLE = (
    r"cars?|vans?|trucks?|lorr(?:y|ies)|bus(?:es)?|coach|taxis?|cabs?|trams?|trains?|ambulances?|tractors?|"
    r"fire engines?|vehicles?|"
    r"auto|wagen|laster|lkw|straßenbahn|voitures?|camions?|coches?|carros?|cami[oó]n"
)
COMES_BACK = re.compile(
    any_of(
        r"com\w+ (?:back|home|soon|later|over for|to (?:visit|see|stay|dinner|lunch))", "return\\w*",
        "kommt (?:gleich |bald )?zurück",
        r"revien\w*", r"vuelv\w*", "to (?:school|work|bed|church)", "home",
        "running (?:late|for office|a business|the)",
        "bab(?:y|ies)(?:'s| is| are) coming", "getting (?:married|old|better|tired|bored|hungry)",
        "playing (?:football|chess|piano|up|the)", "cross(?:ing)? (?:the line|(?:his|her|their|my) fingers)",
        "falling (?:asleep|in love)", "sitting (?:an|her|his) exam",
    ),
    re.IGNORECASE,
)  # fmt: skip
"""Motion that does not lead into the vehicle's path."""
