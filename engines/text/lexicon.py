"""Words by what they are: the little that telling parts of speech in sentences about movement takes, own lists.

Words are in their base form; `base_forms` finds it. Closed classes are complete as far as captions go, open ones hold
what people write of movements; what is in none of them is told by its ending and its neighbours (`engines.text.tags`).
"""

from __future__ import annotations


def words(text: str) -> frozenset[str]:
    """A list of words with spaces between."""
    return frozenset(text.split())


CLOSED: dict[str, str] = {
    **dict.fromkeys(words("a an the this these those each every some any no another all both either neither"), "DET"),
    **dict.fromkeys(
        words(
            "in on at with from by for of into onto over under across through around along above below behind beside "
            "between against toward towards before after during without within near past off out up down upon beneath "
            "inside outside among about as like than until till per via upwards"
        ),
        "ADP",
    ),
    **dict.fromkeys(
        words(
            "zero one two three four five six seven eight nine ten eleven twelve thirteen twenty thirty hundred dozen"
        ),
        "NUM",
    ),
    **dict.fromkeys(
        words(
            "is are was were be been being am has have had having can could will would shall should may might must do "
            "does did"
        ),
        "AUX",
    ),
    **dict.fromkeys(
        words(
            "i you he she it we they me him us them his her its their my your our hers theirs himself herself itself "
            "themselves yourself myself who whom whose which what someone somebody anyone anybody something anything "
            "nothing everyone others other that there"
        ),
        "PRON",
    ),
    **dict.fromkeys(
        words(
            "then again very once twice here away together back not n't too so almost also just often always never "
            "still yet already ahead aside apart forth sideways sidewards upward downward inward outward outwards "
            "inwards thrice overhead somewhere anywhere hardly ever well far soon now clockwise counterclockwise "
            "anticlockwise forward forwards backward backwards quite rather slightly straight"
        ),
        "ADV",
    ),
    **dict.fromkeys(words("and or but nor if while when because since though although whether 's '"), "OTHER"),
}
"""Word -> part of speech."""
POSSESSIVE = words("his her its their my your our 's whose")
"""What a noun comes after."""

VERBS = words(
    """walk run jog jump hop leap step turn wave raise lift lower bend squat kneel sit stand lie rise throw catch kick
    punch push pull swing shake clap bow dance climb march sprint dash stroll stretch crouch lunge spin twist rotate
    roll crawl swim balance stumble trip fall slip slide skip shuffle limp sneak tiptoe strut stomp stamp reach grab
    pick put place bring carry hold drop move go come take make give get draw trace write wipe wash rub scratch touch
    tap pat knock hit strike slap block dodge duck lean tilt nod point beckon gesture signal greet salute cross fold
    open close play shoot dribble bounce serve bowl bat toss hurl pitch juggle row paddle pedal drive steer eat drink
    pour stir cook clean sweep scrub brush comb type read call answer respond invite guide direct show say speak talk
    sing cheer applaud celebrate warm exercise train practise practice box fight fence parry slash cut jab lock curl
    perform start begin stop continue keep try use work look face watch search circle wheel pace back return repeat
    straighten flap flail sway rock wiggle shrug hug embrace wrestle tackle race break land stay wait rest relax sleep
    pose act pretend mimic imitate walk cartwheel somersault flip handle hang dangle hover lift press squeeze grip
    release let spread swirl sidestep backpedal retreat approach enter leave stagger wobble stoop shove swipe charge
    bound prance trot gallop trudge plod stride saunter wander amble tread clamber mount outline join tuck extend hug
    step pass change shift pause drag hit lead follow threaten motion direct wheel appear seem happen mop paint hammer
    chop dig peel climb vault dive float fly glide pirouette curtsy kneel leapfrog skate ski shadow-box lob"""
)
"""Base forms of what people do; many of them are nouns as well."""

NOUNS = words(
    """person man woman human figure people child boy girl player actor character body someone walk run jog jump hop
    leap step turn wave swing kick punch push throw catch shake clap bow dance climb march sprint stroll stretch
    crouch lunge squat spin twist circle line corner curve angle way pace speed place spot side front back top bottom
    middle centre center air ground floor wall door window table chair seat stairs stair ladder ball bat racket
    racquet basket basketball baseball tennis football golf club box weight dumbbell rope bar sword hand arm leg foot
    knee elbow shoulder head neck chest waist hip torso wrist ankle finger thumb fist palm face eye ear mouth chin
    back thigh forearm heel toe motion movement gesture greeting farewell goodbye call answer exercise sport game
    music rhythm beat second minute time moment direction height level inch meter metre foot feet energy strength ease
    grace anger joy pride rest stance pose position manner style fashion fight boxing stroke serve shot hit pass
    cartwheel somersault handstand pirouette letter triangle square x object thing something item bottle cup glass
    phone book bag rock stone dog horse car bike beam balance street playground frame room house circle touch drink
    draw drop lift slip slide fall knock point pull break stop start look rest roll cut play row signal show step"""
)
"""Base forms."""

ADJECTIVES = words(
    """slow quick fast happy sad angry tired old young big small large little tall short long high low wide narrow
    straight curved full empty heavy light strong weak hard soft loud quiet calm steady normal natural usual proud shy
    drunk elderly feminine masculine youthful childish lively energetic exhausted weary worn cheerful gentle careful
    careless sudden smooth rough uneven bumpy firm stiff loose relaxed tense nervous confident hesitant clumsy graceful
    elegant left right front upper lower outer inner far near close deep same different several many few more most
    other next last first second third single double half whole entire imaginary invisible right-hand left-hand free
    seated upright vertical horizontal diagonal circular raised bent crossed open closed furious leisurely"""
)

IRREGULAR: dict[str, str] = {
    "ran": "run", "sat": "sit", "stood": "stand", "threw": "throw", "thrown": "throw", "took": "take", "taken": "take",
    "went": "go", "gone": "go", "came": "come", "made": "make", "gave": "give", "given": "give", "got": "get",
    "held": "hold", "bent": "bend", "swung": "swing", "spun": "spin", "hung": "hang", "caught": "catch",
    "brought": "bring", "drew": "draw", "drawn": "draw", "rose": "rise", "risen": "rise", "lay": "lie", "lain": "lie",
    "lying": "lie", "leapt": "leap", "knelt": "kneel", "leant": "lean", "leaned": "lean", "shook": "shake",
    "shaken": "shake", "struck": "strike", "fell": "fall", "fallen": "fall", "slid": "slide", "swam": "swim",
    "began": "begin", "begun": "begin", "kept": "keep", "put": "put", "hit": "hit", "cut": "cut", "shot": "shoot",
    "wrote": "write", "written": "write", "drank": "drink", "ate": "eat", "eaten": "eat", "drove": "drive",
    "strode": "stride", "trod": "tread", "crept": "creep", "fought": "fight", "swept": "sweep", "dove": "dive",
    "broke": "break", "broken": "break", "led": "lead", "men": "man", "women": "woman", "people": "person",
    "feet": "foot", "children": "child", "dying": "die", "tying": "tie",
}  # fmt: skip
"""Forms that no ending tells."""


def base_forms(word: str) -> list[str]:
    """A word, and what it could be a form of, likelier ones first: waves -> wave, hopping -> hop, tries -> try."""
    found = [word]
    if word in IRREGULAR:
        found.append(IRREGULAR[word])
    for ending in ("ing", "ed", "es", "s", "er", "d"):
        stem = word.removesuffix(ending)
        if stem == word or len(stem) < 2 or (ending == "s" and stem.endswith("s")):
            continue
        if ending in {"ing", "ed", "er"} and len(stem) > 2 and stem[-1] == stem[-2] and stem[-1] not in "sl":
            found.append(stem[:-1])
        if stem.endswith("i") and ending != "ing":
            found.append(stem[:-1] + "y")
        found += [stem] if ending in {"s", "d"} else [stem, stem + "e"]
        if ending == "ing" and len(stem) > 2 and stem[-1] == stem[-2]:
            found.append(stem[:-1])
    return list(dict.fromkeys(found))


def is_any(word: str, among: frozenset[str]) -> bool:
    """Is the word, or what it is a form of, among these?"""
    return any(form in among for form in base_forms(word))
