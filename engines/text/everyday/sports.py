"""How people ask for sports: blows, blades, balls and exercises."""

from __future__ import annotations

SENTENCES: dict[str, str] = {
    "punch": """
        punch; throw a punch; He punches the bag once.; a hard blow; hit someone; striking; a karate strike;
        She lands a punch on the villain.; punch straight ahead; give him a knuckle sandwich; sock him one;
        The hero knocks the bad guy out with one blow.; strike with the fist; smash a board with your fist;
        My brother hits the pillow.; a fist to the jaw; a person punches; uppercut; wallop; hit the target hard;
        someone punches a hole in the wall; deliver a single strike; He swings a fist at the bully.;
        a good old thump""",
    "boxing": """
        boxing; box; shadow boxing; The boxer trades blows with his opponent.; one-two, one-two;
        jab and cross combinations;
        She works the punching bag, fist after fist.; sparring; He spars with an invisible opponent.; in the ring;
        a flurry of punches; left, right, left, right, fists flying; boxing match, round one; boxing training;
        My cousin practises her jabs and hooks.; keep your guard up and throw combinations; boxer in the gym;
        punch with one fist, then the other, again and again; the champion dances around and jabs;
        glove work with a partner; a person boxes; Float like a butterfly, sting like a bee.;
        he hammers the speed bag with both fists; gloves on, punching in turn; a prize fighter at work;
        fists up, alternate punches""",
    "kick": """
        kick; He kicks the ball.; a high kick; roundhouse kick; She kicks the door in.; take a penalty kick; kicking;
        shoot at goal; karate kick; The striker takes a free kick.; give the can a kick; hit it with your foot;
        swing your leg and strike; My son kicks a pebble down the road.; a kick to the shin; front kick;
        boot the ball downfield; a person kicks; the punter kicks the football; volley it into the net with the foot;
        A taekwondo fighter kicks at head height.; lash out with a foot; kick the tyre; football shot; a toe poke;
        pass the ball with the inside of the foot""",
    "slash": """
        slash; slash with a sword; He cuts through the air with a blade.; one clean cut; slashing; swing the machete;
        The samurai draws and cuts once.; hack through the vines; a diagonal cut with the sword;
        slice the melon in half; She chops down with an invisible blade.; cleave; bring the katana down; a sweeping cut;
        swish of the blade; My friend swings a stick like a sword, once.; strike with a sabre; chop with the axe;
        slice it in two; a person slashes downward; the knight deals one mighty stroke of the sword;
        cut the rope with a single stroke; Slice the air with a blade, shoulder to hip.; a slash across;
        behead the dragon; he lops off a branch with a machete""",
    "sword fight": """
        sword fight; a fencing lesson; He fences with an opponent.; en garde!; a duel with swords;
        Two knights cross swords.;
        She parries and strikes with her sword.; parry, riposte; fencing match; swordplay; lightsaber duel;
        pirates fighting with cutlasses; The musketeer defends himself against three blades.; thrust and parry;
        fight somebody sword in hand; a person sword fights; kendo bout; fence with a foil;
        duelling at dawn with rapiers; My sister takes fencing lessons.; blade against blade, back and forth;
        clashing swords; stage combat with swords; the gladiator battles on, sword in hand;
        attack and block with a sword, again and again; a swashbuckler in action""",
    "throw": """
        throw; throw a ball; He throws a stone across the lake.; an overhand throw; throwing; pitch a baseball;
        She hurls a snowball.; toss the ball to your friend; javelin throw; The quarterback throws a long pass.;
        fling it as far as you can; lob a water balloon; My dog waits while I throw the stick.; a fast pitch;
        the pitcher winds up and lets go; chuck it away; a person throws something; throw the spear;
        send the ball flying with one arm; He tosses the paper into the bin.; hurl; throw a dart; cast the net overhand;
        Throw it here!; the fielder throws to first base; a grenade throw in a video game""",
    "catch": """
        catch; catch the ball; He catches it with both hands.; catching; a great catch; Think fast!;
        I got it, the ball is mine!; She grabs the frisbee out of the air.; The goalkeeper catches the ball.;
        receive a pass with your hands; somebody tosses him the keys and he catches them; catch a falling vase;
        snatch it out of the air; My little sister catches the balloon.; the receiver pulls in the pass;
        catch what is thrown at you; a person catches something; hold out your hands and catch;
        the bride throws the bouquet, her friend catches it; The catcher gloves the pitch.;
        intercept the ball in flight; the keeper has safe hands; grab it before it falls;
        an apple drops and he catches it; outfielder making the catch; be ready for the ball and hold on to it""",
    "basketball shot": """
        shoot a basketball; shoot some hoops; He takes a free throw.; jump shot; three-pointer; basketball shot;
        She shoots from behind the line.; nothing but net; Score a basket.; put the ball through the hoop;
        The guard shoots at the buzzer.; shooting hoops; a shot at the basket with both hands; free throw line;
        My cousin practises his shot at the hoop on the garage.; aim at the basket and shoot; slam it in the hoop;
        a person shoots a basketball; from downtown, and it's in!; two hands, high arc, into the basket;
        swish, three points; Basketball player scoring.; set shot; the last shot of the game goes up to the rim; layup;
        bank it off the backboard""",
    "dribble": """
        dribble; dribble a basketball; He bounces the ball up the court.; bouncing a basketball; dribbling;
        She dribbles between the cones.; keep the ball bouncing; The point guard brings the ball up.; dribble drill;
        bounce the ball with one hand; pat the basketball to the floor again and again; ball handling practice;
        My neighbour's kid dribbles in the driveway all day.; bounce, bounce, bounce, hand on ball; crossover dribble;
        a person dribbles a basketball; low dribble; the player dribbles and waits for a gap;
        basketball warm-up, dribbling; don't pick up the ball, keep dribbling;
        he drives with the ball bouncing at his side; street ball dribbling; Bounce the ball while you move.;
        harlem style ball bouncing; she dribbles past the defender; showing off his handles with a basketball""",
    "bowling": """
        bowling; bowl; He bowls a strike.; roll the ball down the lane; ten pins; She goes for a spare.; bowling alley;
        send the bowling ball down the lane; swing the arm back and let the ball roll; My dad is great at bowling.;
        skittles;
        knock down all the pins; The bowler slides up to the line and releases.; underhand roll of a heavy ball;
        send the ball at the pins; a night at the bowling alley; a person bowls; all ten pins fall!;
        throw a gutter ball; lawn bowls; Aim at the pins and roll.;
        she picks up a bowling ball and sends it down the alley; bowling ball release;
        the last frame, he needs a strike; petanque, rolled low; let it roll along the floor from a low swing""",
    "baseball swing": """
        swing a bat; baseball swing; He swings at the pitch.; hit a home run; batter up; batting practice;
        She hits the baseball out of the park.; the batter swings and misses; home run!; swing for the fences;
        The slugger takes a big cut with the bat.; swinging a baseball bat; at bat; bat the ball;
        hit the piñata with a bat; My uncle bats third for his team.; a swing with both hands on the bat;
        a person swings a baseball bat; at the batting cage; he steps up to the plate and swings; softball hit;
        whack the ball with a bat; batter at home plate; Get ready at the plate, then swing.; line drive off the bat;
        a powerful bat swing""",
    "tennis swing": """
        tennis forehand; swing a racket; He returns the ball with his racket.; backhand; forehand; a tennis stroke;
        She hits a forehand down the line.; tennis swing; rally on the tennis court; swing the tennis racket;
        The tennis player sends the ball back over the net.; groundstroke; hit a tennis ball after the bounce;
        My mother plays tennis on Sundays.; topspin forehand; return the serve with a forehand; playing tennis;
        a person swings a tennis racket; hit the ball from the baseline; a cross-court shot with the racket;
        low racket swing; squash shot; Swing the racket at waist height.; volley at the net with a racket;
        he chases the ball and slices it back; practising strokes against the tennis wall""",
    "tennis serve": """
        tennis serve; serve; He tosses the ball up and serves.; an ace; serve the tennis ball; overhead serve;
        She opens the game with a serve.; second serve; serving for the match; hit the ball overhead with a racket;
        The tennis pro serves at match point.; toss, racket up, smash; big serve; new game, her serve; double fault;
        My tennis coach shows me how to serve.; start the point with a serve; a person serves in tennis; overhead smash;
        forty-love, he serves; Serve it over the net.; throw the ball high and strike it with the racket;
        a serve down the middle at Wimbledon; racket over the head and down on the ball; first service;
        he serves an ace""",
    "arm curl": """
        arm curl; bicep curls; He curls a pair of dumbbells.; lift weights with your arms; pumping iron; curls;
        She trains her biceps.; dumbbell curl; barbell curls; bend the elbows and bring the weights up; arm workout;
        The bodybuilder works on his arms.; hammer curls; curl both forearms up and down; biceps day at the gym;
        My roommate does curls with water bottles.; elbows at your sides, hands up to the shoulders; a set of ten curls;
        a person curls weights; strengthen your upper arms; lift the dumbbells to your shoulders; curling weights;
        flex both arms as if holding dumbbells; lower the weights slowly, then curl again; Do some arm exercises.;
        weight lifter doing biceps""",
    "lunge": """
        lunge; do a lunge; He lunges forward.; forward lunge; lunges; a deep step forward and back again;
        leg day, lunges; She sinks into a lunge.; one big step ahead, bend the knee, return;
        stretch the hips with a lunge; lunging; The trainer demonstrates lunges.; warrior pose, front knee bent;
        step forward and drop the back knee; My physiotherapist wants me to do lunges.; drop to one knee and come back;
        proposing on one knee; long step, low hips; a person does a lunge; split stance, down and up;
        Step out far and push back.; bodyweight lunge; front leg bent, back leg long;
        exercise for the thighs, one leg in front; he kneels as if to be knighted, then steps back;
        alternate legs, lunging""",
    "squat": """
        squat; do some squats; He squats down and gets back up.; deep knee bends; squats; air squat; a set of squats;
        She bends her knees until she is nearly on her heels.; crouch down low, then up; knee bend; leg day, squats;
        The weightlifter squats with the bar on his back.; go down as if on an invisible chair and up again; squatting;
        My gym buddy does fifty squats.; lower the hips, back straight, come up;
        exercise your thighs, feet side by side; a person squats; as low as your knees allow, then up; goblet squat;
        duck down and rise; he crouches to look under the car; Bend both knees deeply.;
        down, up, down, up, with the knees; hunker down; crouch like a frog""",
}
