//! The protocol's published packets, encoded and decoded on the target.

#[embedded_test::tests(executor = mps2::Executor::new())]
mod tests {
    use mps2::Board;

    #[init]
    fn init() -> Board {
        mps2::init()
    }

    #[test]
    fn published_packets(_board: Board) {
        assert!(!dynamixel::examples::EXAMPLES.is_empty());
        assert!(dynamixel::examples::check().is_ok());
    }
}
