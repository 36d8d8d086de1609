"""kinestatics: differential kinematics and statics of robot arms."""
