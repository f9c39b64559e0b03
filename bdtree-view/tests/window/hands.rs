//! A pointer on the virtual display: its events come from the X server, as a person's do.

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ClientMessageEvent, ConnectionExt as _, EventMask,
    InputFocus, MOTION_NOTIFY_EVENT, MapState, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

use crate::display::Display;

pub(crate) const LEFT: u8 = 1;

/// A connection that sends events to a window.
pub(crate) struct Hands {
    connection: RustConnection,
    root: Window,
    window: Window,
}

impl Hands {
    /// On the one window that is shown on a display. It gets the keyboard, as from a window manager.
    ///
    /// # Panics
    /// Where there is no such window.
    pub(crate) fn on(display: &Display) -> Self {
        let (connection, screen) = x11rb::connect(Some(&display.name)).expect("the display");
        let root = connection.setup().roots[screen].root;
        let tree = connection.query_tree(root).expect("sent");
        let windows = tree.reply().expect("the windows").children;
        let mut shown = windows.into_iter().filter(|window| {
            let attributes = connection.get_window_attributes(*window).expect("sent");
            attributes
                .reply()
                .is_ok_and(|a| a.map_state == MapState::VIEWABLE)
        });
        let window = shown.next().expect("a window");
        assert_eq!(shown.next(), None, "one window");
        drop(shown);
        connection
            .set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME)
            .expect("sent")
            .check()
            .expect("the window takes the keyboard");
        Self {
            connection,
            root,
            window,
        }
    }

    fn send(&self, kind: u8, detail: u8, [x, y]: [u32; 2]) {
        let [x, y] = [x, y].map(|n| i16::try_from(n).expect("on the display"));
        self.connection
            .xtest_fake_input(kind, detail, x11rb::CURRENT_TIME, self.root, x, y, 0)
            .expect("sent")
            .check()
            .expect("XTEST");
    }

    /// Moves the pointer to a pixel of the display.
    pub(crate) fn point(&self, at: [u32; 2]) {
        self.send(MOTION_NOTIFY_EVENT, 0, at);
    }

    pub(crate) fn press(&self, button: u8) {
        self.send(BUTTON_PRESS_EVENT, button, [0; 2]);
    }

    pub(crate) fn release(&self, button: u8) {
        self.send(BUTTON_RELEASE_EVENT, button, [0; 2]);
    }

    /// Asks the window to close, as a window manager does.
    pub(crate) fn close(&self) {
        let atom = |name: &str| {
            let atom = self.connection.intern_atom(false, name.as_bytes());
            atom.expect("sent").reply().expect("an atom").atom
        };
        let data = [atom("WM_DELETE_WINDOW"), x11rb::CURRENT_TIME, 0, 0, 0];
        let event = ClientMessageEvent::new(32, self.window, atom("WM_PROTOCOLS"), data);
        self.connection
            .send_event(false, self.window, EventMask::NO_EVENT, event)
            .expect("sent")
            .check()
            .expect("a message");
    }

    /// Takes the window away, without asking.
    pub(crate) fn destroy(&self) {
        let destroyed = self.connection.destroy_window(self.window);
        destroyed.expect("sent").check().expect("a window");
    }
}
