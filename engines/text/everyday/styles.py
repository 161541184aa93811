"""How people ask for a manner: phrases that may follow any verb phrase."""

from __future__ import annotations

_AGED = """
    like a pensioner; hunched with age; as if eighty years old; like somebody's grandmother; with creaking joints;
    like an old man; with aching bones; bent by the years; frail and slow; as a senior citizen would; at a ripe old age;
    with stiff old knees"""
_CHILD = """
    like a kid; like a five-year-old; in the playful way of a little kid; as a toddler would; like a kindergartner;
    as kids do; with a child's clumsiness; being silly; like an eager schoolchild; like a small boy at play;
    like a little girl; with childish delight"""

PHRASES: dict[str, str] = {
    "active": """
        bursting with energy; briskly; with vigour; full of beans; with a spring in the step; dynamically; vigorously;
        as if after three coffees; wide awake; with get-up-and-go; spiritedly; raring to go""",
    "angry": """
        stomping with rage; in a fury; boiling with anger; mad as hell; in a temper; with clenched teeth; fuming;
        as if looking for a fight; in a rage; aggressively; seeing red; irritated; enraged; ready to explode""",
    "childish": _CHILD,
    "childlike": _CHILD,
    "chimpira": """
        like a gangster; like a hoodlum; like a petty yakuza; looking for trouble; like a bully; like a punk;
        with a thug's swagger; trying to look tough; like a small-time crook; cocky and threatening;
        spoiling for trouble; like a delinquent""",
    "depressed": """
        without any hope; as if life had no meaning; in deep despair; hopelessly; seeing no way out; in utter gloom;
        as if nothing mattered any more; crushed by grief; deep in depression; listless and hopeless; desolately""",
    "drunk": """
        after too many beers; tipsy; staggering from drink; wasted; after a night at the bar; reeling; plastered;
        three sheets to the wind; intoxicated; swaying from wine; hammered; under the influence""",
    "elderly": _AGED,
    "exhausted": """
        completely spent; ready to collapse; at the end of their strength; as if after a marathon; dead on their feet;
        drained of all energy; barely able to go on; utterly exhausted; burnt out; about to drop; on the last legs;
        gasping with exhaustion""",
    "female model": """
        like a supermodel; as if on a runway; like a model at a fashion show; posing for the photographers;
        as on an imaginary catwalk; like a cover girl; as if modelling a dress; with a model's poise; at fashion week;
        like a top model""",
    "feminine": """
        like a lady; in a womanly way; ladylike; in a girly way; daintily; with delicate femininity; as a woman would;
        swaying the hips; elegantly, like a lady; with a woman's elegance; femininely; girlishly""",
    "giant": """
        like a colossus; as if ten metres tall; like an ogre; as if the earth shook; like a huge troll; like Godzilla;
        like a titan; enormous and ponderous; like an elephant; as if towering over houses;
        with massive heavy movements; as a monster the size of a house would""",
    "happy": """
        beaming with joy; full of joy; joyfully; over the moon; in a great mood; with a smile;
        as if having won the lottery; delighted; gladly; merrily; on cloud nine; as if it were a birthday""",
    "heavy": """
        as if made of lead; carrying a great weight; as if wearing iron boots; ponderously; as if loaded with bags;
        lumbering; as if weighing a ton; like a very heavy man; as though the limbs were lead; under a heavy load""",
    "hurried": """
        already late; rushing; against the clock; in a rush; with no time to lose; hastily; late for the train;
        in haste; as quickly as possible; pressed for time; as if the bus were about to leave""",
    "lazy": """
        hardly bothering; like a slacker; as if it were too much work; half-heartedly; with the least effort;
        like a couch potato; sluggishly; like a sloth; without lifting a finger more than needed; idly;
        in no mood to work""",
    "masculine": """
        like a man; manly; in a macho way; like a tough guy; broad-shouldered; as a strong man would; like a cowboy;
        with masculine strength; virile; like a real bloke; in a manly manner; with a man's firmness""",
    "musical": """
        to the beat; in time with the music; as if a song were playing; in rhythm; grooving; following a melody;
        to a tune; with music in the ears; like a musician feeling the beat; to the sound of a band; swinging to a song;
        keeping time""",
    "normal": """
        normally; as usual; the ordinary way; just like that; in the usual manner; as anyone would; naturally;
        nothing special; plainly; in a neutral way; like on any other day; without any particular mood""",
    "old": _AGED,
    "proud": """
        with the head held high; like a champion; full of pride; like a king; as if having won a medal; self-assured;
        like a proud parent; with confidence; chin up and chest out; triumphantly; like a winner; tall and dignified;
        nobly; with self-respect""",
    "robot": """
        like a machine; robotically; like an android; as if remote-controlled; with jerky mechanical movements;
        like a wind-up toy; like a cyborg; as if run by motors; like a tin man; in a stiff, automatic way""",
    "sad": """
        close to tears; with tears in the eyes; heartbroken; feeling blue; in mourning; sorrowfully; unhappily;
        with sorrow; head hanging; as if having lost a friend; miserable; down in the dumps; gloomily""",
    "sexy": """
        flirting; sensually; in an alluring way; temptingly; like a seductress; suggestively; to turn heads;
        like a femme fatale; flirtatiously; trying to seduce someone""",
    "sneaky": """
        like a thief; on the sly; without a sound; like a burglar in the night; like a ninja; trying not to be seen;
        furtively; secretly; like a spy; so that nobody notices""",
    "soldier": """
        in a military manner; like an army recruit; as if on parade; stiff, as at attention; like a guardsman;
        in uniform; with drill-ground precision; like a sergeant; as ordered by an officer; like a marine""",
    "strutting": """
        like a peacock; with a strut; full of swagger; like a rooster; parading about; cockily; making an entrance;
        as if owning the place; like a rock star; wanting everyone to look""",
    "tired": """
        sleepily; yawning; as if short of sleep; drowsily; after a long day; needing a nap; fatigued; a bit worn;
        low on energy; like after a night shift; half asleep; ready for bed""",
    "unconfident": """
        shyly; hesitantly; full of self-doubt; nervously; like a wallflower; insecurely; afraid of doing it wrong;
        with shoulders drawn in; bashfully; as if everyone were staring; with little self-esteem;
        hardly daring to look up; meekly""",
    "youthful": """
        like a teenager; with the freshness of youth; like a young adult; as a student would; young at heart;
        like a teen; in the prime of youth; like a twenty-year-old; light and young; with young limbs;
        like somebody in their twenties; with teenage bounce""",
    "zombie": """
        like the living dead; like a walking corpse; risen from the grave; undead; as if craving brains;
        like an extra in a zombie film; like the undead; arms out and lifeless; mindlessly, like a ghoul;
        half rotten""",
}
