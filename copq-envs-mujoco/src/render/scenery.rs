//! What a picture needs besides the robot: sky, tiles, light.

/// Tiles have the size of those in `copq_render::animation`: half a metre.
const ASSETS: &str = r#"<asset>
<texture type="skybox" builtin="gradient" rgb1="0.96 0.97 0.99" rgb2="0.74 0.81 0.89" width="256" height="256"/>
<texture name="tiles" type="2d" builtin="checker" rgb1="0.78 0.82 0.87" rgb2="0.62 0.68 0.75" width="256" height="256"/>
<material name="tiles" texture="tiles" texrepeat="1 1" texuniform="true"/>
</asset>
"#;

/// The lamp follows the robot, because only a limited area around it can have shadows.
const LAMP: &str = r#"<light mode="trackcom" directional="true" pos="-2 -3 8" dir="0.25 0.375 -1" diffuse="0.55 0.55 0.55"/>
"#;

/// The MJCF of a robot with scenery, which does not affect the physics.
pub(super) fn add(mjcf: &str, [width, height]: [u32; 2]) -> String {
    let visual = format!(
        "<visual>\n<global offwidth=\"{width}\" offheight=\"{height}\"/>\n<quality offsamples=\"4\" shadowsize=\"2048\"/>\n\
         <headlight ambient=\"0.4 0.4 0.4\" diffuse=\"0.3 0.3 0.3\" specular=\"0.1 0.1 0.1\"/>\n\
         <map shadowclip=\"3\"/>\n<rgba haze=\"0.96 0.97 0.99 1\"/>\n</visual>\n"
    );
    mjcf.replacen("<worldbody>\n", &format!("{visual}{ASSETS}<worldbody>\n{LAMP}"), 1)
        .replace("type=\"plane\"", "type=\"plane\" material=\"tiles\"")
}
