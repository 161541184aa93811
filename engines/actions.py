"""The one action vocabulary over all data sets: about fifty names, each with a description and a group."""

from __future__ import annotations

from dataclasses import dataclass

from engines.errors import UnknownLabelError


@dataclass(frozen=True)
class Action:
    """A name a person can ask for."""

    name: str
    """Lower case, words apart: "wave left hand"."""
    description: str
    """A sentence on what the person does."""
    group: str
    """Shelf in the browser: locomotion, gestures, sports, everyday, dance and play."""
    mirrors: bool = False
    """Whether the action seen in a mirror is the action its mirrored name says (its own name if unsided)."""

    @property
    def repeats(self) -> bool:
        """Whether it goes on for as long as one likes (walking) rather than being done once (a throw)."""
        return (self.group == "locomotion" and self.name not in {"jump", "leap"}) or self.name in _GO_ON


_GO_ON = frozenset({
    "wave left hand", "wave right hand", "wave both hands", "dribble", "dance", "sword fight", "wash", "balance",
})  # fmt: skip

VOCABULARY: tuple[Action, ...] = (
    Action("walk", "A person walks forward.", "locomotion", mirrors=True),
    Action("walk backward", "A person walks backward.", "locomotion", mirrors=True),
    Action("walk left", "A person walks diagonally to the left, facing ahead.", "locomotion", mirrors=True),
    Action("walk right", "A person walks diagonally to the right, facing ahead.", "locomotion", mirrors=True),
    Action("turn left", "A person walks and turns to the left.", "locomotion", mirrors=True),
    Action("turn right", "A person walks and turns to the right.", "locomotion", mirrors=True),
    Action("walk in place", "A person walks on the spot.", "locomotion", mirrors=True),
    Action("walk on rough ground", "A person picks their way over uneven ground.", "locomotion", mirrors=True),
    Action("run", "A person runs forward.", "locomotion", mirrors=True),
    Action("dash", "A person sprints forward.", "locomotion", mirrors=True),
    Action("jog in place", "A person jogs on the spot.", "locomotion", mirrors=True),
    Action("jump", "A person jumps forward or up with both feet.", "locomotion", mirrors=True),
    Action("hop", "A person jumps up and down and hops on one foot.", "locomotion", mirrors=True),
    Action("leap", "A person runs and leaps.", "locomotion", mirrors=True),
    Action("climb", "A person climbs, hangs and gets down on playground equipment.", "locomotion", mirrors=True),
    Action("wave left hand", "A person waves with the left hand.", "gestures", mirrors=True),
    Action("wave right hand", "A person waves with the right hand.", "gestures", mirrors=True),
    Action("wave both hands", "A person waves with both hands.", "gestures", mirrors=True),
    Action("raise left hand", "A person raises the left hand and lowers it.", "gestures", mirrors=True),
    Action("raise right hand", "A person raises the right hand and lowers it.", "gestures", mirrors=True),
    Action("raise both hands", "A person raises both hands and lowers them.", "gestures", mirrors=True),
    Action("bow", "A person bows.", "gestures", mirrors=True),
    Action("wave goodbye", "A person waves goodbye with one hand.", "gestures"),
    Action("wave goodbye big", "A person waves goodbye with a wide swing of the arm.", "gestures"),
    Action("beckon", "A person calls somebody over with an arm.", "gestures"),
    Action("guide", "A person shows the way with an arm.", "gestures"),
    Action("respond", "A person answers a call with a gesture.", "gestures"),
    Action("clap", "A person claps.", "gestures", mirrors=True),
    Action("cross arms", "A person crosses the arms in front of the chest.", "gestures"),
    Action("swipe left", "A person swipes with the right arm to the left.", "gestures"),
    Action("swipe right", "A person swipes with the right arm to the right.", "gestures"),
    Action("draw x", "A person draws an X in the air with the right hand.", "gestures"),
    Action("draw circle clockwise", "A person draws a circle in the air, clockwise.", "gestures"),
    Action("draw circle counterclockwise", "A person draws a circle in the air, counterclockwise.", "gestures"),
    Action("draw triangle", "A person draws a triangle in the air with the right hand.", "gestures"),
    Action("punch", "A person punches and strikes.", "sports"),
    Action("boxing", "A person boxes, left and right in turn.", "sports", mirrors=True),
    Action("kick", "A person kicks.", "sports"),
    Action("slash", "A person slashes as with a sword.", "sports"),
    Action("sword fight", "A person fences and strikes with a sword.", "sports"),
    Action("throw", "A person throws overhand with the right arm.", "sports"),
    Action("catch", "A person catches something.", "sports"),
    Action("basketball shot", "A person shoots a basketball with both hands.", "sports", mirrors=True),
    Action("dribble", "A person dribbles a basketball.", "sports"),
    Action("bowling", "A person bowls with the right arm.", "sports"),
    Action("baseball swing", "A person swings a baseball bat.", "sports"),
    Action("tennis swing", "A person swings a tennis racket with the right arm.", "sports"),
    Action("tennis serve", "A person serves overhead with a tennis racket.", "sports"),
    Action("arm curl", "A person curls both forearms as with dumbbells.", "sports", mirrors=True),
    Action("lunge", "A person lunges forward and comes back.", "sports"),
    Action("squat", "A person squats down and stands up.", "sports", mirrors=True),
    Action("push", "A person pushes something away with the hands.", "everyday", mirrors=True),
    Action("knock", "A person knocks on a door.", "everyday"),
    Action("pick up and throw", "A person bends down, picks something up and throws it.", "everyday"),
    Action("sit down", "A person sits down.", "everyday", mirrors=True),
    Action("stand up", "A person gets up from sitting.", "everyday", mirrors=True),
    Action("wash", "A person washes themself.", "everyday", mirrors=True),
    Action("reach up", "A person jumps up to grab, reaches and stands on tiptoe.", "everyday", mirrors=True),
    Action("dance", "A person dances: turns, arabesques, small leaps.", "dance and play", mirrors=True),
    Action("cartwheel", "A person turns a cartwheel.", "dance and play", mirrors=True),
    Action("balance", "A person balances on one leg, arms out.", "dance and play", mirrors=True),
)  # fmt: skip

_BY_NAME = {action.name: action for action in VOCABULARY}


def get(name: str) -> Action:
    """The action of that name (case and extra blanks do not matter).

    Raises:
        UnknownLabelError: no such action; the message lists the nearest known.
    """
    cleaned = " ".join(str(name).lower().split())
    if cleaned not in _BY_NAME:
        raise UnknownLabelError("action", name, _BY_NAME)
    return _BY_NAME[cleaned]
