"""How people ask for what is done at home and at play."""

from __future__ import annotations

SENTENCES: dict[str, str] = {
    "push": """
        push; push the door open; He pushes a stalled car.; shove; pushing; She shoves the box away.; give it a push;
        push something heavy; The mover pushes a piano across the room.; get it out of the way with both hands;
        lean into the wall and push; My dad pushes the swing.; shove him back; a hard push;
        keep off, hands out in front; push the trolley; a person pushes something away; press against the boulder;
        thrust the hands forward; Push harder!; he slides the wardrobe into the corner;
        push an intruder out of the door; shoving; the mime presses against an invisible wall;
        She pushes her plate away.; move the sofa by pushing it""",
    "knock": """
        knock; knock on the door; He raps on the door.; knock knock, who's there; knocking; is anybody home?;
        tap on the window;
        She knocks three times and waits.; The neighbour is at the door.; bang on the door; pound on the gate;
        police, open up!; a gentle knock; My landlord knocks about the rent.; rap with the knuckles; door knock;
        a person knocks; the delivery man has no bell to ring; trick or treat at the neighbour's door;
        hammer on the wood; Knock before you enter.; knuckles against the bathroom door; he wants to be let in;
        room service, she says at the door; tap tap tap on the door; the visitor announces himself at the door""",
    "pick up and throw": """
        pick up a stone and throw it; He bends down, grabs a ball and throws it.; pick it up and toss it;
        grab and throw; She scoops up snow and hurls a snowball.; lift it off the ground and fling it;
        picking up and throwing; take the rock from the floor, then throw;
        The fielder gathers the ball off the grass and throws it in.;
        My kid picks pebbles off the beach and flings them.; stoop, pick up, throw; bend, grab, chuck; scoop and toss;
        a person picks something up and throws it; He collects the litter and tosses it into the bin.;
        pick up the stick and throw it for the dog; get that thing off the floor and hurl it away; lift and hurl;
        fetch the ball from the ground and send it back; off the ground and off it flies; reach down, then throw;
        the rioter picks up a bottle and throws it; Pick up, aim, throw.;
        she finds a flat stone and skips it on the lake; someone grabs a pillow off the floor and throws it;
        bends over for the ball and pitches it""",
    "sit down": """
        sit; sit down; take a seat over there; He sits down on a chair.; have a seat, please; sitting down;
        She sinks into the sofa.; lower yourself onto the bench; My feet hurt, I need a chair.; The class sits.;
        plop down on the couch; grab a chair; the judge takes her seat; be seated; a person sits down;
        He settles into the armchair.; find your seat at the cinema; squeeze in at the table; pull up a stool;
        from standing to sitting; time for dinner, everyone sits down; park yourself over there;
        She drops into her office chair.; take the weight off; The passenger sits by the window.; sit on the floor""",
    "stand up": """
        stand up; get up; He rises from his chair.; on your feet!; getting up; She gets up from the sofa.; please rise;
        stand up from the bench; The court rises for the judge.; rise; leave your seat; up from the chair; stop sitting;
        My grandfather gets out of his armchair.; time to go, he pushes himself up from his seat;
        from sitting to standing; a person stands up; he offers his seat on the bus; She rises from the table.;
        get off the couch; the national anthem starts and everyone gets up; straighten up out of the seat;
        back on your feet after the meal; Up you get!; stand, after sitting; the student stands up to speak""",
    "wash": """
        wash; wash yourself; He takes a shower.; have a shower; washing; She washes her face.; scrub your arms;
        lather up with soap; My brother sings under the shower.; soap and water; rub yourself clean; get clean;
        rinse off the shampoo; The miner scrubs off the dirt.; wash your hair; have a bath; a person washes;
        hands over the body with a sponge; After the match the player washes.; splash water on your face; freshen up;
        washing the neck and shoulders; wash behind your ears; she rubs soap all over; scrubbing up; shower time""",
    "reach up": """
        reach up; reach for the top shelf; She stands on tiptoe to get the jar.; reaching; grab something high up;
        He jumps up to grab the branch.; get the cookies off the cupboard; on tiptoe, arm stretched up;
        too high, stretch; The ball is stuck in the tree and she tries to get it.; pick an apple from a high branch;
        stretch for the lamp; My grandmother reaches for the upper shelf.; jump and grab it; change a light bulb;
        get the box from the wardrobe; a person reaches up; he can't quite touch the ceiling; Reach as high as you can.;
        up on your toes and grab; a shopper reaches for the last box on the top rack; take the hat down from its hook;
        fetch the suitcase from above; the rope dangles just out of her reach;
        grasp at the balloon that is floating off; pluck a star from the sky""",
    "dance": """
        dance; He dances.; a little dance; a bit of ballet; She twirls across the floor.; dancing;
        groove along with the beat; pirouette;
        The ballerina performs an arabesque.; show me your moves; swan lake; dancing at the ball;
        dance like nobody is watching; My aunt dances at the wedding.; spin and float like a dancer; a graceful dance;
        modern dance; prima ballerina; a person dances; the music starts and she can't keep still;
        He practises his ballet steps.; dance class; Dance for us!; turns and small leaps like a ballerina;
        a dance recital; waltz around on your own; nutcracker solo""",
    "cartwheel": """
        one clean cartwheel; do a cartwheel; She turns a cartwheel on the lawn.; cartwheels;
        a sideways somersault on the hands;
        He wheels over his hands and lands on his feet.; wheel on your hands; gymnastics, one cartwheel;
        The gymnast cartwheels.; hands down, legs over, back on your feet; My niece cartwheels across the beach.;
        upside down and round again; legs fly over the head like spokes; a person does a cartwheel;
        acrobatics on the lawn; tumble sideways; side wheel; roundoff; Spin sideways over your hands.;
        the cheerleader's favourite trick, hands then feet; a tumbling pass; show me a cartwheel;
        head over heels, sideways; he goes over like a wheel; capoeira wheel, over the hands;
        gym class, wheel over the mat""",
    "balance": """
        balance; stand on one leg; She balances on one foot.; balancing; tightrope walker holding still;
        arms out, one leg up; He tries not to fall, on one leg.; flamingo; like a flamingo; tree pose;
        keep your balance; yoga on one leg; The acrobat balances with arms stretched out.; hold still on one foot;
        My physio has me stand on one leg.; one foot off the ground, stay steady; a person balances;
        wobbling on one leg; balance on a beam; stork stance; Lift one foot and hold it there.;
        arms spread like wings, one leg raised; test your sense of balance; the karate kid in his crane pose;
        steady now, one leg only; she teeters on one foot with her arms out""",
}
