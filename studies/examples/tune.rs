use models::filter::{*, modes::*};
use studies::scenes::*;
use std::sync::Arc;
fn score(scene:&Scene, noise:&Noise, seed:u64, runs:u64, config:&FilterConfig)->(f64,f64,f64){
    let (mut raw, mut err, mut nees, mut n)=(0.0,0.0,0.0,0.0);
    for run in 0..runs {
        let p=plots(scene,noise,seed,run);
        let mut f=Estimator::from_plot(config,&p[0]).unwrap();
        for (k,plot) in p.iter().enumerate().skip(1){
            f.update(plot).unwrap();
            let (e,kk)= if config.rung==Rung::Mh9Lag1 { match f.lagged(){Some(e)=>(e,k-1),None=>continue} } else {(f.estimate(),k)};
            if kk<3 {continue;}
            let t=scene.at(kk as f64).position_m;
            raw+=(p[kk].position_m-t).norm_squared(); err+=(e.position_m()-t).norm_squared();
            nees+=consistency::position_nees(&e,t); n+=1.0;
        }
    }
    (100.0*(1.0-err/raw), nees/n, raw/n)
}
fn main(){
    let noise=NoiseLevel::all()[0].noise;
    let scenes=[Scene::landing(),Scene::landing_arc(),Scene::takeoff(),Scene::queue()];
    for (rung,name) in Rung::ALL {
        let config=FilterConfig::new(rung);
        print!("{name:10}");
        for s in &scenes { let r=score(s,&noise,7,300,&config); print!(" {:6.1} ({:.2})",r.0,r.1); }
        let p=plots(&scenes[0],&noise,7,0);
        let mut blocks=vec![];
        for _ in 0..300 { let t0=std::time::Instant::now(); for _ in 0..16 { let mut f=Estimator::from_plot(&config,&p[0]).unwrap();
            for q in &p[1..] { let _=std::hint::black_box(f.update(q)); std::hint::black_box(f.estimate().state.x); } }
            blocks.push(t0.elapsed().as_nanos() as f64/(16.0*61.0)); }
        blocks.sort_by(f64::total_cmp);
        println!("  min {:.1} median {:.1} p99 {:.1} ns", blocks[0], blocks[150], blocks[296]);
    }
}
