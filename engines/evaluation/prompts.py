"""Sixty sentences as people type them, and the actions that would be right: does an engine do what it is told in words?

None of them is a caption of the training data. Right is a motion whose likeliest action, to the recogniser, is among
those accepted; several are where words leave it open. `prompts_more.MORE` is a second list in the same form, three
sentences for each action.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from engines.metrics.evaluators import Recogniser
from engines.motion import Motion

_WALKS = ("walk", "walk on rough ground", "walk left", "walk right")
PROMPTS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("a man strolls through the park", _WALKS),
    ("she walks forward at an easy pace", _WALKS),
    ("an old woman shuffles ahead slowly", _WALKS),
    ("walk like you have just won a prize", _WALKS),
    ("a tired person trudges home", _WALKS),
    ("step backwards carefully", ("walk backward",)),
    ("someone retreats, walking in reverse", ("walk backward",)),
    ("go for a run", ("run", "dash")),
    ("a jogger passes by", ("run", "dash", "jog in place")),
    ("sprint as fast as you can", ("dash", "run")),
    ("a furious man charges ahead", ("dash", "run")),
    ("walk ahead, then turn to the left", ("turn left",)),
    ("a person makes a left turn while walking", ("turn left",)),
    ("turn right as you walk", ("turn right",)),
    ("he walks and swings round to the right", ("turn right",)),
    ("march on the spot", ("walk in place", "jog in place")),
    ("jog without moving from your place", ("jog in place", "walk in place")),
    ("leap into the air with both feet", ("jump", "hop", "leap", "reach up")),
    ("jump forward", ("jump", "hop", "leap")),
    ("wave hello with your left hand", ("wave left hand",)),
    ("her left hand waves at a friend", ("wave left hand",)),
    ("wave the right hand", ("wave right hand",)),
    ("greet somebody by waving your right arm", ("wave right hand",)),
    ("wave with both arms", ("wave both hands",)),
    ("both hands wave in the air to get attention", ("wave both hands",)),
    ("lift your left arm", ("raise left hand",)),
    ("the pupil puts the left hand up", ("raise left hand",)),
    ("raise the right hand to ask a question", ("raise right hand",)),
    ("put your right arm up", ("raise right hand",)),
    ("raise both arms above the head", ("raise both hands",)),
    ("hands up", ("raise both hands", "wave both hands")),
    ("take a polite bow", ("bow",)),
    ("bend forward in greeting", ("bow",)),
    ("say goodbye with a wave", ("wave goodbye", "wave goodbye big", "wave right hand", "wave left hand")),
    ("call someone over", ("beckon", "wave goodbye", "wave goodbye big", "guide")),
    ("show a guest the way with your arm", ("guide", "beckon")),
    ("clap your hands", ("clap",)),
    ("applaud the show", ("clap",)),
    ("fold your arms in front of you", ("cross arms",)),
    ("draw a circle in the air", ("draw circle clockwise", "draw circle counterclockwise")),
    ("draw a big X with the right hand", ("draw x",)),
    ("throw a few punches", ("punch", "boxing")),
    ("box with left and right", ("boxing", "punch")),
    ("throw a ball overarm", ("throw", "tennis serve", "pick up and throw")),
    ("catch something that flies at you", ("catch",)),
    ("shoot a basketball at the hoop", ("basketball shot",)),
    ("bounce a basketball", ("dribble",)),
    ("roll a bowling ball", ("bowling",)),
    ("swing a baseball bat", ("baseball swing",)),
    ("hit the tennis ball with a forehand", ("tennis swing",)),
    ("serve in tennis", ("tennis serve", "tennis swing")),
    ("do biceps curls", ("arm curl",)),
    ("lunge with one leg", ("lunge",)),
    ("do a squat", ("squat",)),
    ("push a heavy box away", ("push",)),
    ("knock at the door", ("knock",)),
    ("pick something up from the floor and throw it", ("pick up and throw",)),
    ("sit down on a chair", ("sit down",)),
    ("get up from the chair", ("stand up",)),
    ("dance to the music", ("dance",)),
)
"""(sentence, actions that are right)."""


@dataclass(frozen=True)
class Answer:
    """What an engine made of a sentence."""

    prompt: str
    accepted: tuple[str, ...]
    seen: tuple[str, ...]
    """The likeliest action of each motion."""

    @property
    def share(self) -> float:
        """Of the motions that are right."""
        return sum(name in self.accepted for name in self.seen) / len(self.seen)


def answers(
    generate: Callable[[str], Sequence[Motion]],
    recogniser: Recogniser,
    prompts: Sequence[tuple[str, tuple[str, ...]]] = PROMPTS,
) -> list[Answer]:
    """What comes of every sentence.

    Args:
        generate: sentence -> some motions, at least one.
        recogniser: of actions.
        prompts: (sentence, actions that are right): these sixty, or `prompts_more.MORE`.
    """
    return [Answer(prompt, accepted, tuple(recogniser.recognise(generate(prompt)))) for prompt, accepted in prompts]
