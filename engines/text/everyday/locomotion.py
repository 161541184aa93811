"""How people ask for ways of getting about: jumps, runs, walks and climbs."""

from __future__ import annotations

SENTENCES: dict[str, str] = {
    "walk": """
        go for a walk; He strolls down the street.; taking a stroll; My neighbour is out walking her dog.; stride ahead;
        She ambles along the beach.; a leisurely walk; The postman walks from house to house.; walk straight on;
        Somebody wanders through the museum.; just walking; She heads to the shops on foot.;
        Walk to the end of the hallway.; a man walking forward at an ordinary pace; strolling;
        He paces up to the counter.; The bride walks down the aisle.; move forward at walking speed;
        a few steps forward; A tourist saunters along the promenade.; make your way across the room;
        It is a nice day, so he goes to work on foot.; a woman crosses the street; Take ten steps ahead.;
        someone is walking; The actress walks onto the stage and keeps going.; pedestrian""",
    "walk backward": """
        walk backwards; step back a few paces; She backs away from the dog.; backing up; He retreats, facing ahead.;
        a person going in reverse on foot; moonwalking away from the camera; Walk in reverse.; reverse gear on foot;
        The bear has seen him and he slowly backs off.; take several steps back; retreat step by step;
        My sister walks backwards to keep talking to us.; move back without turning round; stepping backward;
        The tour guide walks backward in front of her group.; back out of the room; walking the wrong way round;
        A photographer steps back and back to fit everyone in.; heels first, one step after another;
        He makes his way backwards down the corridor.; Back up until you hit the wall.; backward walk;
        she is walking but not forward, the other way; someone backs away with both eyes on the door;
        a man retreating""",
    "walk left": """
        sidestep to the left; walk diagonally to the left; She drifts left while looking straight ahead.;
        go forward and left without turning; He shifts over to the left as he walks.; crab walk left;
        a slanted walk to the left; The waiter edges left between the tables, still facing forward.; strafe left;
        left strafe; Walk off to the left but keep your face to the front.; sidestepping left;
        move diagonally, front and left; He steps left to let someone pass and goes on.; veer left without rotating;
        A goalkeeper shuffles over to the left.; walking sideways to the left; side steps, left;
        She walks at an angle toward the left, chest to the front.; make room by moving over to the left;
        the actor crosses to stage left, still facing the audience; a diagonal stroll to the left;
        slide over to the left while walking; My uncle slants left along the pavement.; ahead and to the left;
        stepping out to the left side, eyes front""",
    "walk right": """
        sidestep to the right; walk diagonally to the right; He drifts right while looking straight ahead.;
        go forward and right without turning; She shifts over to the right as she walks.; crab walk right;
        a slanted walk to the right; The nurse edges right between the beds, still facing forward.;
        strafe to the right side;
        right strafe; Walk off to the right but keep your eyes to the front.; sidestepping right;
        move diagonally, front and right; She steps right to let a bike pass and goes on.; veer right without rotating;
        A defender shuffles over to the right.; walking sideways to the right; side steps, right;
        He walks at an angle toward the right, chest to the front.; make room by moving over to the right;
        the singer crosses to stage right, still facing the audience; a diagonal stroll to the right;
        slide over to the right while walking; My aunt slants right along the pavement.; ahead and to the right;
        stepping out to the right side, eyes front""",
    "turn left": """
        turn left; take a left at the corner; He walks on and turns left.; a left turn; She curves round to the left.;
        walking in a bend to the left; go round the corner to your left; hang a left; left at the traffic lights;
        The postwoman turns left into the driveway.; bear left and follow the curve; make a left;
        Walk a few steps, then turn to the left.; My neighbour rounds the block, turning left.; walk and swing left;
        he changes direction to the left; a person walks along an arc to the left; heading off left around the bend;
        The path winds left and she follows it.; wheel to the left while walking; turning left as she goes;
        take the first street on the left; a shopper turns left into the next aisle; curve left;
        rotate to the left and walk on; She walks a half circle to the left.""",
    "turn right": """
        turn right; take a right at the corner; She walks on and turns right.; a right turn;
        He curves round to the right.; walking in a bend to the right; go round the corner to your right; hang a right;
        right at the traffic lights; The milkman turns right into the driveway.; make a right;
        bear right and follow the curve; Walk a few steps, then turn to the right.; walk and swing right;
        My cousin rounds the block, turning right.; she changes direction to the right; curve right;
        a person walks along an arc to the right; heading off right around the bend;
        The river winds right and he follows it.; wheel to the right while walking; turning right as he goes;
        take the second street on the right; a visitor turns right into the next gallery;
        rotate to the right and walk on; He walks a half circle to the right.""",
    "walk in place": """
        march in place; walk on the spot; walking without getting anywhere; treadmill walking;
        She steps in place in front of the television.; He takes steps but stays where he is.; stepping on the spot;
        marching on the spot; lift one foot, then the other, without moving forward; stationary walking;
        My mother gets her steps in beside the sofa.; walk but do not go anywhere; keep stepping, keep your spot;
        The mime walks and walks and never leaves his spot.; virtual reality, so she walks in place;
        He is on a treadmill, walking.; step step step, same spot; a person walks without travelling;
        walking in position; tread the ground where you stand; A woman warms up by walking on the spot.;
        go through the motions of walking, standing still; in-place walk; someone marches but gains no ground;
        the drummer marches on the spot waiting for the parade to move; pretend to walk""",
    "walk on rough ground": """
        walk over rocks; She picks her way across the rubble.; hiking over boulders; uneven terrain;
        He steps carefully from stone to stone.; walking on rough ground; a rocky path;
        The hiker crosses a field of loose stones.; cross the riverbed without twisting an ankle;
        stumbling along a bumpy trail; stepping over roots and holes; My dad walks through the ploughed field.;
        watch your footing on the scree; a person walks where the floor is not flat; rough terrain walk;
        They wade through debris after the storm.; a walk along the rocky shore; step over obstacles as you go;
        clambering over ruins on foot; trek across broken ground; He minds every step on the cobbles and potholes.;
        the ground is full of bumps and she keeps walking; walking across a building site full of bricks;
        picking a path through fallen branches; Walk as if the ground were all lumps.; a walk off the beaten track""",
    "run": """
        get a quick run in before breakfast; He runs down the road.; jogging in the park;
        She is out for her morning run.; run forward;
        running; a steady run; My neighbour jogs around the block.; A marathon runner somewhere in the middle.;
        jog along the river; The dog is loose and he runs after it.; keep running; a person running ahead;
        It starts to rain and they run for shelter.; run across the field; a ten kilometre run at an even pace;
        The referee runs along with the game.; she trots along the path; run a lap; cross-country runner;
        training for the half marathon; He jogs up to his friends.; a woman jogging forward; run to the other side;
        The children run to the gate.; faster than a walk, but no race; jogger""",
    "dash": """
        sprint; run as fast as you can; He sprints for the finish line.; a hundred metre dash; full speed ahead;
        She bolts out of the starting blocks.; sprinting; The thief takes off at top speed.; flat out sprinting;
        go all out, top speed running; My brother dashes for the last train.; race to the end of the street;
        A sprinter explodes off the line.; make a dash for it; run like the wind; a mad sprint;
        She tears across the pitch.; running at maximum speed; He hurtles down the track.; wind sprints;
        a bull is after him and he flees at full tilt; someone shoots off like a rocket; dash to the door;
        Run for your life!; the winger blazes past everybody; olympic sprinter; a burst of speed on foot""",
    "jog in place": """
        jog on the spot; run in place; jogging without moving forward; She jogs in place at the traffic lights.;
        warm up with a jog on the spot; running on the spot; He bounces from foot to foot like a runner waiting.;
        a stationary jog; treadmill run; pretend to run without going anywhere; keep your feet running where you stand;
        The gym class runs on the spot.; a person jogging but staying put; jog, same place, half a minute;
        He runs and runs and does not get ahead.; high knees on the spot; light jog, no travel;
        The runner keeps warm at the red light.; my trainer tells me to run in place; in-place running;
        cardio in the living room, running on the spot; jog where you are; A woman on a treadmill runs.;
        the footballer jogs on the spot on the touchline; quick feet without leaving the spot; running in place""",
    "jump": """
        jump; He jumps over a puddle.; a big jump forward; a standing jump for distance; vertical jump; jump up high;
        She jumps with both feet together.; Jump off the ground.; one jump, straight up; box jump;
        My cousin jumps over the crack in the floor.; broad jump; bend your knees and spring up;
        The cat scares her and she jumps.; jumping; a person jumps into the air and lands; spring into the air;
        He takes off with two feet and lands a metre further.; jump down the last step; get off the ground;
        jump as high as you can; A basketball player jumps straight up for the tip-off.; two-footed jump;
        someone jumps ahead from a standstill; crouch, then jump; the kid jumps onto the next tile""",
    "hop": """
        hop on one foot; She hops along on one leg.; play hopscotch on the pavement; hopping; bounce up and down;
        jumping up and down;
        He has stubbed his toe and hops about.; like a pogo stick; little hops on the spot; hop hop hop;
        The fans bounce up and down in the stands.; a person hops; skip on one leg; several small jumps in a row;
        My daughter plays hopscotch on the pavement.; hop to the wall without putting the other foot down;
        one shoe is lost, so he hops; bouncing like a rubber ball; Hop like a bunny.; bob up and down on your toes;
        A girl jumps rope on one foot.; the floor is hot and she keeps bouncing; keep hopping; single-leg hops;
        someone jumps up and down; a man hops while pulling on a sock""",
    "leap": """
        take a running leap; He runs up and leaps across the ditch.; long jump with a run-up; leaping;
        She sprints a few steps and flies over the stream.; a grand leap after a short run; leap over the gap;
        The deer hunter leaps over a fallen log at a run.; run and then jump as far as you can; bounding leap;
        a hurdler clears the hurdle; The long jumper hits the board and takes off.; leap from roof to roof;
        He bounds over the fence without stopping.; a person leaps through the air after running; run, leap, land;
        one huge stride through the air; Leap like a gazelle.; my friend takes a flying leap across the brook;
        with a run-up, over the puddle; she vaults forward in one long leap; a flying stride in mid-run; running jump;
        A parkour runner bridges the gap between two walls.; take off from one foot at a run;
        the steeplechaser leaps over the water""",
    "climb": """
        climb; monkey bars; hanging from the bar; She climbs up the jungle gym.; He swings across the monkey bars.;
        climbing on the playground; climb up the ladder of the slide; pull yourself up and hang;
        A boy scrambles up the climbing frame.; hang there a bit, then get down; climb down again; clambering up;
        My niece hangs by her arms from the frame.; up the ladder, rung by rung; a person climbs;
        dangle from the top bar; She gets down off the climbing frame.; playing on the jungle gym; go up the ladder;
        The kids at the playground climb on everything.; haul yourself up onto the bars; climb the rope net;
        he lowers himself from the bar to the ground; someone climbs, hangs for a moment and lets go;
        scale the climbing wall; hand over hand along the bars""",
}
